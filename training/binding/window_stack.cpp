#include "window_stack.hpp"

#include <string>

#include "kernels/isa.hpp"
#include "kernels/kernel_table.hpp"
#include "pipeline/check_config.hpp"
#include "pipeline/depth_decode.hpp"
#include "pipeline/focus.hpp"
#include "pipeline/working_grid.hpp"
#include "recording/error.hpp"
#include "recording/replay.hpp"

namespace egofocus::training {
namespace {

const KernelTable& kernels() {
  static const KernelTable table = select_kernels(detect_isa());
  return table;
}

}  // namespace

Config WindowStack::checked(const Config& config) {
  recording::require(check_config(config), "window");
  return config;
}

Config WindowStack::cropped(const Config& config, const Crop& crop) {
  Config out = config;
  out.grid = working_grid(config);
  out.threads = 1;
  if (crop.width == 0) return out;
  const bool inside = crop.x >= 0 && crop.y >= 0 && crop.width >= 16 && crop.height >= 16 &&
                      crop.width <= out.grid.width_px - crop.x && crop.height <= out.grid.height_px - crop.y;
  if (!inside) {
    throw recording::Error(recording::ExitCode::kConfiguration,
                           "crop " + std::to_string(crop.width) + "x" + std::to_string(crop.height) + " at " +
                               std::to_string(crop.x) + "," + std::to_string(crop.y),
                           "does not lie in the grid of " + std::to_string(out.grid.width_px) + "x" +
                               std::to_string(out.grid.height_px) + ", or is below 16 px.");
  }
  out.grid.width_px = crop.width;
  out.grid.height_px = crop.height;
  out.grid.cx_px -= crop.x;
  out.grid.cy_px -= crop.y;
  return out;
}

std::size_t WindowStack::bytes_needed(const Config& config, const Config& crop_config) {
  Arena counter;
  const EventFilter filter(config, counter);
  const EventWindow window(config.window, config.camera.intrinsics, counter);
  const Warp warp(crop_config, kernels(), counter);
  return counter.used_bytes();
}

WindowStack::WindowStack(const Config& config, const Crop& crop, std::span<const Ray> rays)
    : config_(checked(config)),
      crop_config_(cropped(config, crop)),
      whole_grid_(working_grid(config)),
      memory_(bytes_needed(config_, crop_config_)),
      arena_(memory_.span()),
      filter_(config_, arena_),
      window_(config_.window, config_.camera.intrinsics, arena_),
      warp_(crop_config_, kernels(), arena_) {
  if (rays.empty()) {
    warp_.prepare(config_.camera);
  } else {
    warp_.prepare(rays);
  }
  recording::require(pool_.start(1, 0, -1), "window", recording::ExitCode::kInternal);
}

bool WindowStack::add(const Event& event) noexcept {
  if (!filter_.keep(event)) return false;
  window_.add(event);
  return true;
}

bool WindowStack::run(std::int64_t oldest_us, std::int64_t tick_us, const TrackFunction& track) {
  ladder_ = {};
  selection_ = {};
  if (oldest_us >= tick_us || !track(oldest_us, tick_us, track_)) return false;
  ladder_ = choose_ladder(config_.ladder, whole_grid_, track_);
  selection_ = window_.select(ladder_.begin_us, tick_us);
  if (!ladder_.has_parallax || selection_.count == 0 || !track(ladder_.begin_us, tick_us, track_))
    return false;
  warp_.project(window_, selection_, track_, ladder_, 0, 1);
  warp_.vote(0, 1);
  return true;
}

ClassicalDepth WindowStack::classical(bool smoothing) {
  Config config = crop_config_;
  config.focus.smoothing = smoothing;
  Arena counter;
  const Focus counted(config, 1, counter);
  const DepthDecode decode_counted(config.grid, true, counter);
  const ArenaMemory memory(counter.used_bytes());
  Arena arena(memory.span());
  Focus focus(config, 1, arena);
  DepthDecode decode(config.grid, true, arena);
  const auto pixels =
      static_cast<std::size_t>(config.grid.width_px) * static_cast<std::size_t>(config.grid.height_px);
  ClassicalDepth out{std::vector<std::uint16_t>(pixels), std::vector<std::uint8_t>(pixels)};
  decode.run(focus.run(warp_, ladder_, track_.knots[0].centre_m, pool_), pool_, out.index_q8, out.confidence);
  return out;
}

NetworkInput WindowStack::input(const FocusInputConfig& config) {
  return network_input(config, crop_config_.grid, config_.ladder.hypotheses, warp_.planes(), ladder_,
                       track_.knots[0].centre_m, pool_);
}

}  // namespace egofocus::training
