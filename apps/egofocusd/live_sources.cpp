#include "live_sources.hpp"

#include <string>
#include <utility>

#include "core/clock.hpp"
#include "hal/usb_camera_source.hpp"
#include "hal/v4l2_source.hpp"
#include "recording/recording_source.hpp"

namespace egofocus::daemon {
namespace {

using recording::Error;
using recording::ExitCode;
using recording::require;

void require_device(const Status& status, const std::string& where) {
  require(status, where, status.code() == StatusCode::kNoDevice ? ExitCode::kNoDevice : ExitCode::kDevice);
}

// clock = "device": samples keep the time of the device that they come from.
template <typename Settings>
Settings with_time_of(const Setup& setup, Settings settings) {
  settings.device_time = setup.daemon.source.clock == ClockKind::kDevice;
  return settings;
}

struct UsbCamera {
  UsbCamera(const UsbCameraSettings& settings, const UsbIo& io)
      : buffers(UsbCameraSource::buffer_bytes(settings)), source(settings, buffers, io, monotonic_clock()) {}
  std::vector<std::byte> buffers;
  UsbCameraSource source;
};

struct V4l2Camera {
  explicit V4l2Camera(const V4l2CameraSettings& settings)
      : copy(V4l2CameraSource::buffer_bytes(settings)), source(settings, copy, monotonic_clock()) {}
  std::vector<std::byte> copy;
  V4l2CameraSource source;
};

struct CanBus {
  CanBus(const SocketCanConfig& config, std::unique_ptr<CanMotionDecoder> motion, Recorder& recorder)
      : decoder(std::move(motion)),
        source(config, *decoder, {&recorder, [](void* self, const CanFrame& frame) noexcept {
                                    static_cast<Recorder*>(self)->take(frame);
                                  }}) {}
  std::unique_ptr<CanMotionDecoder> decoder;
  SocketCanSource source;
};

void require_size(SensorSize size, const Setup& setup) {
  const Intrinsics& camera = setup.camera.config.camera.intrinsics;
  if (size.width_px == camera.width_px && size.height_px == camera.height_px) return;
  throw Error(ExitCode::kConfiguration, setup.camera_file.string(),
              "says " + std::to_string(camera.width_px) + "x" + std::to_string(camera.height_px) +
                  " px, but the camera has " + std::to_string(size.width_px) + "x" +
                  std::to_string(size.height_px) + ". Use the calibration of this sensor.");
}

template <typename Camera>
void open_camera(std::shared_ptr<Camera> camera, const char* section, const Setup& setup, OpenSources& open) {
  require_device(camera->source.open(), std::string(section) + " of " + setup.camera_file.string());
  require_size(camera->source.info().size, setup);
  open.devices.emplace_back([source = &camera->source](auto& facts) { tell(source->counters(), facts); });
  open.to_attach.push_back(camera->source.source());
  open.kept.push_back(std::move(camera));
}

void open_usb(const Setup& setup, OpenSources& open) {
  const UsbIo* const usb = system_usb();
  if (usb == nullptr) {
    throw Error(ExitCode::kNoDevice, "[source] events",
                "this build has no USB. Install libusb (Debian: libusb-1.0-0-dev) and build again with "
                "EGOFOCUS_USB=ON.");
  }
  open_camera(std::make_shared<UsbCamera>(with_time_of(setup, setup.camera.usb.camera), *usb), "[usb]", setup,
              open);
}

// [camera] has the size that a node without a known sensor does not tell.
void open_v4l2(const Setup& setup, OpenSources& open) {
  const Intrinsics& camera = setup.camera.config.camera.intrinsics;
  V4l2CameraSettings settings = with_time_of(setup, setup.camera.v4l2.camera);
  settings.size = {static_cast<std::uint16_t>(camera.width_px), static_cast<std::uint16_t>(camera.height_px)};
  open_camera(std::make_shared<V4l2Camera>(settings), "[v4l2]", setup, open);
}

void open_can(const Setup& setup, Recorder& recorder, OpenSources& open) {
  const recording::CanSetup& can = setup.camera.can;
  if (can.dbc.empty()) {
    throw Error(ExitCode::kConfiguration, setup.camera_file.string(),
                "lacks the section [can]: motion = \"can\" needs a DBC and its signals (docs/formats.md).");
  }
  const std::filesystem::path dbc = setup.camera_file.parent_path() / can.dbc;
  const SocketCanConfig interface = setup.daemon.can;
  auto bus = std::make_shared<CanBus>(with_time_of(setup, interface),
                                      recording::make_can_decoder(can, setup.dbc, dbc), recorder);
  require_device(bus->source.start(), std::string("[can] interface ") + setup.daemon.can.interface_name);
  bus->source.stop();
  open.devices.emplace_back([source = &bus->source](auto& facts) {
    SocketCanHealth health;
    if (source->health(health)) tell(health, facts);
  });
  open.to_attach.push_back(bus->source.source());
  open.kept.push_back(std::move(bus));
}

// Each inlet has one writer.
void require_one_imu(const Setup& setup) {
  const CanMotionConfig& can = setup.camera.can.motion;
  if (setup.daemon.source.events != EventsFrom::kUsb || !setup.camera.usb.camera.imu) return;
  for (std::size_t i = 0; i < can.signal_count; ++i) {
    if (can.signals[i].role > CanRole::kAccelZ) continue;
    throw Error(ExitCode::kConfiguration, setup.camera_file.string(),
                "has two IMUs: [usb] imu = true, and [can] signals with the role " +
                    std::string(to_string(can.signals[i].role)) + ". Remove one.");
  }
}

}  // namespace

OpenSources open_live_sources(const Setup& setup, Recorder& recorder) {
  require_one_imu(setup);
  OpenSources open;
  std::string problems;  // of all devices: who mends one wants to know of the other
  ExitCode code = ExitCode::kOk;
  const auto attempt = [&](const auto& open_one) {
    try {
      open_one();
    } catch (const Error& error) {
      problems += (problems.empty() ? "" : "\n") + std::string(error.what());
      if (code == ExitCode::kOk) code = static_cast<ExitCode>(error.exit_code());
    }
  };
  attempt([&] {
    setup.daemon.source.events == EventsFrom::kUsb ? open_usb(setup, open) : open_v4l2(setup, open);
  });
  attempt([&] { open_can(setup, recorder, open); });
  if (!problems.empty()) throw Error(code, problems);
  return open;
}

}  // namespace egofocus::daemon
