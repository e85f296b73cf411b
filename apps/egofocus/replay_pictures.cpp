#include "replay_pictures.hpp"

#include <algorithm>
#include <cstdio>
#include <string>

#include "recording/depth_picture.hpp"
#include "recording/error.hpp"
#include "recording/png_io.hpp"

namespace egofocus::app {
namespace {

using recording::GreyPicture;
using recording::Rgb;
using recording::RgbPicture;

constexpr std::int32_t kGap_px = 4;
constexpr std::size_t kMostRows = 64;

RgbPicture to_rgb(const GreyPicture& grey) {
  RgbPicture out(grey.width_px, grey.height_px);
  std::transform(grey.pixels.begin(), grey.pixels.end(), out.pixels.begin(), [](std::uint8_t v) {
    return Rgb{v, v, v};
  });
  return out;
}

void paste(const RgbPicture& from, std::int32_t left, std::int32_t top, RgbPicture& to) {
  for (std::int32_t y = 0; y < from.height_px; ++y) {
    for (std::int32_t x = 0; x < from.width_px; ++x) to.at(left + x, top + y) = from.at(x, y);
  }
}

RgbPicture side_by_side(const std::vector<RgbPicture>& pictures) {
  std::int32_t width = -kGap_px;
  std::int32_t height = 0;
  for (const RgbPicture& p : pictures) {
    width += p.width_px + kGap_px;
    height = std::max(height, p.height_px);
  }
  RgbPicture out(width, height, Rgb{255, 255, 255});
  std::int32_t left = 0;
  for (const RgbPicture& p : pictures) {
    paste(p, left, 0, out);
    left += p.width_px + kGap_px;
  }
  return out;
}

// Truth in the colours of the depth beside it: the same inverse depth per unit.
RgbPicture truth_picture(const DepthFrame& frame, std::span<const float> truth_m, std::uint16_t brightest) {
  std::vector<std::uint16_t> inverse(truth_m.size(), 0);
  std::vector<std::uint8_t> known(truth_m.size(), 0);
  for (std::size_t i = 0; i < truth_m.size(); ++i) {
    if (!(truth_m[i] > 0)) continue;
    const double units = 1.0 / (static_cast<double>(truth_m[i]) * frame.inverse_depth_scale_per_m);
    inverse[i] = static_cast<std::uint16_t>(std::min(units, 65535.0));
    known[i] = 255;
  }
  return recording::depth_picture(frame.grid.width_px, frame.grid.height_px, inverse, known, brightest);
}

}  // namespace

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
  for (const char* last : {"overview.png", "report.json"}) std::filesystem::remove(folder_ / last);
}

void ReplayPictures::write(const DepthFrame& frame, const DepthFrame* beside, const Intrinsics& sensor,
                           std::span<const Event> events, std::span<const float> truth_m) {
  char time[24];
  std::snprintf(time, sizeof time, "%012lld", static_cast<long long>(frame.t_us));
  const auto path = [&](const char* kind) { return folder_ / (std::string(time) + "_" + kind + ".png"); };
  // One colour scale for the whole recording: the near limit is brightest.
  const auto brightest_of = [this](const DepthFrame& of) {
    double nearest = 1;
    if (of.inverse_depth_scale_per_m > 0) nearest = 1.0 / (z_near_m_ * of.inverse_depth_scale_per_m);
    return static_cast<std::uint16_t>(std::clamp(nearest, 1.0, 65535.0));
  };
  const std::uint16_t brightest = brightest_of(frame);
  const std::int32_t width = frame.grid.width_px;
  const std::int32_t height = frame.grid.height_px;
  const RgbPicture event_view = recording::event_picture(sensor.width_px, sensor.height_px, events);
  const RgbPicture depth =
      recording::depth_picture(width, height, frame.inverse_depth, frame.confidence, brightest);
  const GreyPicture confidence = recording::confidence_picture(width, height, frame.confidence);
  recording::write_png(path("events"), event_view);
  recording::write_png(path("depth"), depth);
  recording::write_png(path("confidence"), confidence);
  std::vector<RgbPicture> row{event_view, depth, to_rgb(confidence)};
  if (beside != nullptr) {
    row.push_back(recording::depth_picture(width, height, beside->inverse_depth, beside->confidence,
                                           brightest_of(*beside)));
    recording::write_png(path("focus"), row.back());
  }

  if (frame.votes == 0 || seen_++ % stride_ != 0) return;
  if (truth_m.size() == frame.inverse_depth.size()) row.push_back(truth_picture(frame, truth_m, brightest));
  rows_.push_back(side_by_side(row));
  if (rows_.size() < kMostRows) return;
  // A long recording: keep every other row, and look at half as many ticks from here on.
  for (std::size_t i = 0; 2 * i < rows_.size(); ++i) rows_[i] = std::move(rows_[2 * i]);
  rows_.resize(rows_.size() / 2);
  stride_ *= 2;
}

void ReplayPictures::write_overview() const {
  if (rows_.empty()) return;
  const std::size_t count = std::min(kOverviewRows, rows_.size());
  const std::int32_t height = rows_[0].height_px + kGap_px;
  RgbPicture sheet(rows_[0].width_px, static_cast<std::int32_t>(count) * height - kGap_px,
                   Rgb{255, 255, 255});
  for (std::size_t i = 0; i < count; ++i) {
    const RgbPicture& row = rows_[(2 * i + 1) * rows_.size() / (2 * count)];
    if (row.width_px == sheet.width_px && row.height_px == rows_[0].height_px)
      paste(row, 0, static_cast<std::int32_t>(i) * height, sheet);
  }
  recording::write_png(folder_ / "overview.png", sheet);
}

}  // namespace egofocus::app
