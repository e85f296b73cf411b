// Events under D depth hypotheses: the exact rigid form of METHOD section 1. An event's landing point is
// affine in inverse depth, so one add per hypothesis suffices:
//   r = R (x, y, 1),  u_k = f r_x / r_z + c_u + k du,  du = step f (c_x - c_z r_x / r_z),  v_k likewise.
// The projection is IEEE doubles, once per event; what follows is integers (Q16 positions, u8 counts).
#pragma once

#include <cstdint>
#include <span>

#include "core/arena.hpp"
#include "egofocus/config.hpp"
#include "kernels/kernel_table.hpp"
#include "pipeline/event_window.hpp"
#include "pipeline/hypothesis_ladder.hpp"
#include "pipeline/motion_track.hpp"
#include "pipeline/working_grid.hpp"

namespace egofocus {

/// Landing lines of the selected events, structure of arrays; see kernels/warp_vote.hpp for the fields.
struct LandingLines {
  std::span<std::int32_t> u_q16;
  std::span<std::int32_t> v_q16;
  std::span<std::int32_t> du_q16;
  std::span<std::int32_t> dv_q16;
  std::span<std::uint8_t> k_end;
  std::span<std::uint8_t> time_u8;  ///< 0 at the window's begin, 255 at its end; empty: nobody asks
  std::int32_t count = 0;
};

/// One event's line. Pure; the meaning of the whole file. `hypotheses` without a vote have k >= k_end.
struct LandingLine {
  std::int32_t u_q16 = 0;
  std::int32_t v_q16 = 0;
  std::int32_t du_q16 = 0;
  std::int32_t dv_q16 = 0;
  std::int32_t k_end = 0;
};
LandingLine landing_line(const Ray& ray, const MotionKnot& knot, const Intrinsics& grid, double step_per_m,
                         std::int32_t hypotheses) noexcept;

class Warp {
 public:
  static constexpr int kMaxParts = 8;

  /// Takes the ray table (8 bytes per sensor pixel), the lines (18 bytes per event), the stack (1 byte per
  /// hypothesis and grid pixel) and the kernel's scratch (4 bytes per grid pixel and thread) from the arena.
  Warp(const Config& config, const KernelTable& kernels, Arena& arena) noexcept;
  /// For add_votes() alone: no stack, the lines (17 bytes per event) from an arena of their own, and scratch
  /// only where the kernel wants it.
  Warp(const Config& config, const KernelTable& kernels, Arena& arena, Arena lines) noexcept;
  [[nodiscard]] static std::size_t lines_bytes(std::int32_t max_events) noexcept;

  /// Fills the ray table. RT: no (set-up).
  void prepare(const CameraModel& camera) noexcept;
  /// The same from a table that fill_rays() made of the same camera. RT: no (set-up).
  void prepare(std::span<const Ray> rays) noexcept;

  /// Projects part `part` of `parts` of the selected events. Parts may run at once. RT: yes.
  void project(const EventWindow& window, const EventWindow::Selection& selection, const MotionTrack& track,
               const HypothesisLadder& ladder, int part, int parts) noexcept;

  /// Clears and votes the hypotheses of part `part`, after all parts of project(). Parts may run at once. RT:
  /// yes.
  void vote(int part, int parts) noexcept;

  /// Adds the votes of hypotheses first .. first + count - 1 to planes: [count][height][width]. In place of
  /// vote(), for all lines that there are; quickest by kPlanesAtOnce. Parts may run at once. RT: yes.
  static constexpr std::int32_t kPlanesAtOnce = 4;
  void add_votes(std::int32_t first, std::int32_t count, int part, std::uint8_t* planes) noexcept;

  [[nodiscard]] std::uint64_t votes() const noexcept;
  [[nodiscard]] std::uint64_t behind_camera() const noexcept;
  [[nodiscard]] const LandingLines& lines() const noexcept { return lines_; }
  /// Counts of hypothesis k: [height][width], rows without padding.
  [[nodiscard]] std::span<const std::uint8_t> plane(std::int32_t k) const noexcept {
    return stack_.subspan(static_cast<std::size_t>(k) * pixels_, pixels_);
  }
  /// The planes of the last vote() one after the other: [used()][height][width].
  [[nodiscard]] std::span<const std::uint8_t> planes() const noexcept {
    return stack_.first(static_cast<std::size_t>(used_) * pixels_);
  }
  /// One value per grid pixel, all zero but during a vote: whoever borrows it leaves it so.
  [[nodiscard]] std::span<std::uint32_t> scratch() const noexcept { return scratch_[0]; }
  /// Hypotheses of the last project(): planes 0 .. used() - 1 are filled by vote().
  [[nodiscard]] std::int32_t used() const noexcept { return used_; }

 private:
  struct RaysOnly {};
  Warp(RaysOnly, const Config& config, const KernelTable& kernels, Arena& arena) noexcept;

  void take_scratch(int threads, Arena& arena) noexcept;

  struct alignas(kCacheLine) PartCount {
    std::uint64_t votes = 0;
    std::uint64_t behind_camera = 0;
  };

  Intrinsics grid_;
  std::int32_t hypotheses_;
  std::size_t pixels_;
  WarpVoteFunction* vote_;
  std::span<Ray> rays_;
  LandingLines lines_;
  std::span<std::uint8_t> stack_;
  std::span<std::uint32_t> scratch_[kMaxParts];  // the vote kernel's, all zero between calls
  PartCount counts_[kMaxParts];
  int parts_ = 1;
  std::int32_t used_ = 0;  // hypotheses of the tick, <= hypotheses_
};

}  // namespace egofocus
