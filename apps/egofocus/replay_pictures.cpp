#include "replay_pictures.hpp"

#include <cstdio>
#include <string>

#include "recording/depth_picture.hpp"
#include "recording/error.hpp"
#include "recording/png_io.hpp"

namespace egofocus::app {

ReplayPictures::ReplayPictures(std::filesystem::path folder, double z_near_m)
    : folder_(std::move(folder)), z_near_m_(z_near_m) {
  if (!recording::png_available()) {
    throw recording::Error(recording::ExitCode::kUsage, "--out",
                           "this build has no libpng. Install libpng-dev and build again.");
  }
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (error)
    throw recording::Error(recording::ExitCode::kFile, folder_.string(),
                           "cannot be made: " + error.message());
}

void ReplayPictures::write(const DepthFrame& frame, const Intrinsics& sensor,
                           std::span<const Event> events) const {
  char time[24];
  std::snprintf(time, sizeof time, "%012lld", static_cast<long long>(frame.t_us));
  const auto path = [&](const char* kind) { return folder_ / (std::string(time) + "_" + kind + ".png"); };
  // One colour scale for the whole recording: the near limit is brightest.
  double nearest = 1;
  if (frame.inverse_depth_scale_per_m > 0) nearest = 1.0 / (z_near_m_ * frame.inverse_depth_scale_per_m);
  const auto brightest = static_cast<std::uint16_t>(nearest < 65535 ? nearest : 65535);
  const std::int32_t width = frame.grid.width_px;
  const std::int32_t height = frame.grid.height_px;
  recording::write_png(path("events"), recording::event_picture(sensor.width_px, sensor.height_px, events));
  recording::write_png(path("depth"), recording::depth_picture(width, height, frame.inverse_depth,
                                                               frame.confidence, brightest));
  recording::write_png(path("confidence"), recording::confidence_picture(width, height, frame.confidence));
}

}  // namespace egofocus::app
