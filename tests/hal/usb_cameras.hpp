// Cameras as the scripted bus shows them, and a source over one, with its rings.
#pragma once

#include <algorithm>
#include <memory>

#include "core/inlets.hpp"
#include "hal/usb_camera_source.hpp"
#include "scripted_usb.hpp"

namespace scripted {

using namespace egofocus;

constexpr std::uint32_t at(std::uint32_t module, std::uint32_t parameter) {
  return module * 0x10000 + parameter;
}

inline Camera davis346(const std::string& serial = "00000346") {
  Camera camera;
  camera.descriptor = {.vendor = 0x152A,
                       .product = 0x841A,
                       .release = 0x0006,
                       .bus = 1,
                       .address = 7,
                       .serial_index = 3,
                       .speed = UsbSpeed::kSuper};
  camera.serial = serial;
  camera.registers = {{at(6, 0), 18},  {at(6, 1), 5},  {at(6, 2), 1},  {at(6, 5), 80}, {at(6, 6), 1000},
                      {at(6, 7), 1},   {at(0, 80), 1}, {at(0, 83), 0}, {at(0, 84), 0}, {at(1, 0), 346},
                      {at(1, 1), 260}, {at(1, 2), 0},  {at(1, 10), 1}, {at(1, 30), 1}, {at(3, 1), 0}};
  return camera;
}

inline Camera dvxplorer() {
  Camera camera = davis346("DVX00001");
  camera.descriptor.product = 0x8419;
  camera.descriptor.release = 0x0008;
  camera.registers[at(6, 7)] = 2;
  camera.registers[at(1, 0)] = 640;
  camera.registers[at(1, 1)] = 480;
  return camera;
}

inline Camera evk4() {
  Camera camera;
  camera.descriptor = {.vendor = 0x04B4,
                       .product = 0x00F5,
                       .release = 0x0307,
                       .bus = 2,
                       .address = 9,
                       .interface_class = 0xFF,
                       .interface_subclass = 0x19,
                       .serial_index = 0,
                       .speed = UsbSpeed::kSuper};
  camera.numbers = {{0x72, 0x00050123}, {0x79, 0x00030902}, {0x10000, 1}};
  camera.texts = std::string("psee,ccam5_imx636\0psee,ccam5_gen42\0", 35);
  camera.registers = {{0x14, 0xA0401806}, {0xF128, 0}};
  return camera;
}

/// A source over the bus, and the rings that it fills.
struct Bench {
  explicit Bench(Usb& scripted_bus, const UsbCameraSettings& wanted = {})
      : bus(scripted_bus),
        settings(wanted),
        buffers(UsbCameraSource::buffer_bytes(settings)),
        io(bus.io()),
        source(settings, buffers, io, bus.clock.clock()) {}

  Usb& bus;
  UsbCameraSettings settings;
  std::vector<std::byte> buffers;
  std::vector<Event> event_slots = std::vector<Event>(1 << 14);
  std::vector<ImuSample> imu_slots = std::vector<ImuSample>(1 << 10);
  std::vector<OdometrySample> odometry_slots = std::vector<OdometrySample>(64);
  std::vector<PoseSample> pose_slots = std::vector<PoseSample>(64);
  Inlets::Rings rings{SpscRing<Event>(event_slots), SpscRing<ImuSample>(imu_slots),
                      SpscRing<OdometrySample>(odometry_slots), SpscRing<PoseSample>(pose_slots)};
  Inlets inlets{rings};
  UsbIo io;
  UsbCameraSource source;

  UsbCameraPhase phase() const { return source.counters().phase; }
  /// Polls of 10 ms until the phase is reached; false after `most` of them.
  bool poll_until(UsbCameraPhase wanted, int most = 1000) {
    for (int i = 0; i < most; ++i) {
      if (phase() == wanted) return true;
      static_cast<void>(source.poll(inlets, 10'000));
    }
    return phase() == wanted;
  }
  /// start() and the start sequence.
  bool stream() { return source.start().ok() && poll_until(UsbCameraPhase::kStreaming); }
  Delivery poll(int times = 1) {
    Delivery delivery;
    for (int i = 0; i < times; ++i) delivery = source.poll(inlets, 10'000);
    return delivery;
  }
  std::vector<Event> events() {
    std::vector<Event> all;
    for (std::span<const Event> some = rings.events.peek(1 << 14); !some.empty();
         some = rings.events.peek(1 << 14)) {
      all.insert(all.end(), some.begin(), some.end());
      rings.events.release(some.size());
    }
    return all;
  }
  std::vector<ImuSample> imu() {
    const std::span<const ImuSample> some = rings.imu.peek(1 << 10);
    std::vector<ImuSample> all(some.begin(), some.end());
    rings.imu.release(some.size());
    return all;
  }
};

}  // namespace scripted
