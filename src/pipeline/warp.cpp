#include "pipeline/warp.hpp"

#include "core/check.hpp"
#include "core/elementary.hpp"

namespace egofocus {
namespace {

constexpr double kQ16 = 65536.0;
constexpr double kMaxPosition_px = 8000.0;  // keeps |u + 63 du| below 2^30 in Q16
constexpr double kMinDepthRatio =
    1e-3;  // r_z: depth in the reference view over depth at the event, without c_z

// Nearest integer, half up.
std::int32_t round_q16(double px) noexcept {
  return static_cast<std::int32_t>(floor_of(px * kQ16 + 0.5));
}

MotionKnot difference(const MotionKnot& b, const MotionKnot& a) noexcept {
  MotionKnot out;
  for (int i = 0; i < 9; ++i) out.rotation[i] = b.rotation[i] - a.rotation[i];
  for (int i = 0; i < 3; ++i) out.centre_m[i] = b.centre_m[i] - a.centre_m[i];
  return out;
}

// a + share * (b - a)
MotionKnot between(const MotionKnot& a, const MotionKnot& to_b, double share) noexcept {
  MotionKnot out;
  for (int i = 0; i < 9; ++i) out.rotation[i] = a.rotation[i] + share * to_b.rotation[i];
  for (int i = 0; i < 3; ++i) out.centre_m[i] = a.centre_m[i] + share * to_b.centre_m[i];
  return out;
}

LandingLines take_lines(std::int32_t max_events, bool with_time, Arena& arena) noexcept {
  const auto events = static_cast<std::size_t>(max_events);
  LandingLines lines;
  lines.u_q16 = arena.array<std::int32_t>(events);
  lines.v_q16 = arena.array<std::int32_t>(events);
  lines.du_q16 = arena.array<std::int32_t>(events);
  lines.dv_q16 = arena.array<std::int32_t>(events);
  lines.k_end = arena.array<std::uint8_t>(events);
  if (with_time) lines.time_u8 = arena.array<std::uint8_t>(events);
  return lines;
}

[[gnu::always_inline]] inline LandingLine line_of(const Ray& ray, const MotionKnot& knot,
                                                  const Intrinsics& grid, double step_per_m,
                                                  std::int32_t hypotheses) noexcept {
  const double* r = knot.rotation;
  const double x = static_cast<double>(ray.x);
  const double y = static_cast<double>(ray.y);
  const double r_z = r[6] * x + r[7] * y + r[8];
  if (!(r_z > kMinDepthRatio)) return {};
  const double a = (r[0] * x + r[1] * y + r[2]) / r_z;
  const double b = (r[3] * x + r[4] * y + r[5]) / r_z;
  const double u = grid.fx_px * a + grid.cx_px;
  const double v = grid.fy_px * b + grid.cy_px;
  if (!(absolute(u) < kMaxPosition_px && absolute(v) < kMaxPosition_px)) return {};
  const double c_z = knot.centre_m[2];
  double du = step_per_m * grid.fx_px * (knot.centre_m[0] - c_z * a);
  double dv = step_per_m * grid.fy_px * (knot.centre_m[1] - c_z * b);
  std::int32_t k_end = hypotheses;
  // Behind the reference camera: k * step * c_z >= 1.
  while (k_end > 0 && (k_end - 1) * step_per_m * c_z >= 1.0) --k_end;
  const double largest = kMaxPosition_px / hypotheses;
  // More than 125 px from one hypothesis to the next: nothing to compare, and it could leave the Q16 range.
  if (!(absolute(du) < largest && absolute(dv) < largest)) {
    du = 0;
    dv = 0;
    k_end = k_end < 1 ? k_end : 1;
  }
  return {round_q16(u), round_q16(v), round_q16(du), round_q16(dv), k_end};
}

}  // namespace

LandingLine landing_line(const Ray& ray, const MotionKnot& knot, const Intrinsics& grid, double step_per_m,
                         std::int32_t hypotheses) noexcept {
  return line_of(ray, knot, grid, step_per_m, hypotheses);
}

std::size_t Warp::lines_bytes(std::int32_t max_events) noexcept {
  Arena counter;
  static_cast<void>(take_lines(max_events, false, counter));
  return counter.used_bytes();
}

Warp::Warp(const Config& config, const KernelTable& kernels, Arena& arena) noexcept
    : Warp(RaysOnly{}, config, kernels, arena) {
  lines_ = take_lines(config.window.max_events, true, arena);
  stack_ = arena.array<std::uint8_t>(pixels_ * static_cast<std::size_t>(hypotheses_));
  take_scratch(config.threads, arena);
}

Warp::Warp(const Config& config, const KernelTable& kernels, Arena& arena, Arena lines) noexcept
    : Warp(RaysOnly{}, config, kernels, arena) {
  lines_ = take_lines(config.window.max_events, false, lines);
  if (wants_scratch(kernels.warp_vote.isa)) take_scratch(config.threads, arena);
}

Warp::Warp(RaysOnly, const Config& config, const KernelTable& kernels, Arena& arena) noexcept
    : grid_(working_grid(config)),
      hypotheses_(config.ladder.hypotheses),
      pixels_(static_cast<std::size_t>(grid_.width_px) * static_cast<std::size_t>(grid_.height_px)),
      vote_(kernels.warp_vote.run) {
  const Intrinsics& sensor = config.camera.intrinsics;
  rays_ = arena.array<Ray>(static_cast<std::size_t>(sensor.width_px) *
                           static_cast<std::size_t>(sensor.height_px));
}

void Warp::take_scratch(int threads, Arena& arena) noexcept {
  for (int i = 0; i < threads; ++i) scratch_[i] = arena.array<std::uint32_t>(pixels_);
}

void Warp::prepare(const CameraModel& camera) noexcept {
  fill_rays(camera, rays_);
}

void Warp::prepare(std::span<const Ray> rays) noexcept {
  EGOFOCUS_CHECK(rays.size() == rays_.size());
  for (std::size_t i = 0; i < rays_.size(); ++i) rays_[i] = rays[i];
}

void Warp::project(const EventWindow& window, const EventWindow::Selection& selection,
                   const MotionTrack& track, const HypothesisLadder& ladder, int part, int parts) noexcept {
  if (part == 0) {
    lines_.count = static_cast<std::int32_t>(selection.count);
    parts_ = parts;
    used_ = ladder.count;
  }
  counts_[part] = {};
  const std::uint64_t n = selection.count;
  const auto first =
      static_cast<std::uint32_t>(n * static_cast<unsigned>(part) / static_cast<unsigned>(parts));
  const auto last =
      static_cast<std::uint32_t>(n * (static_cast<unsigned>(part) + 1) / static_cast<unsigned>(parts));
  if (first == last) return;
  const std::int64_t length_us = track.end_us - track.begin_us;
  const double knots_per_us =
      length_us > 0 ? (MotionTrack::kKnots - 1) / static_cast<double>(length_us) : 0.0;
  const bool with_time = !lines_.time_u8.empty();
  std::uint64_t behind = 0;
  EventWindow::Reader reader(window, selection, first);
  int last_knot = -1;  // events come in order of time: to the next knot is as far for many of them
  MotionKnot to_next;
  for (std::uint32_t i = first; i < last; ++i) {
    const EventWindow::Selected event = reader.next();
    const std::int64_t since_us = event.t_us - track.begin_us;
    const double at = static_cast<double>(since_us) * knots_per_us;
    int knot = static_cast<int>(at);
    if (knot > MotionTrack::kKnots - 2) knot = MotionTrack::kKnots - 2;
    if (knot != last_knot) {
      to_next = difference(track.knots[knot + 1], track.knots[knot]);
      last_knot = knot;
    }
    const MotionKnot motion = between(track.knots[knot], to_next, at - knot);
    const LandingLine line = line_of(rays_[event.pixel], motion, grid_, ladder.step_per_m, ladder.count);
    lines_.u_q16[i] = line.u_q16;
    lines_.v_q16[i] = line.v_q16;
    lines_.du_q16[i] = line.du_q16;
    lines_.dv_q16[i] = line.dv_q16;
    lines_.k_end[i] = static_cast<std::uint8_t>(line.k_end);
    if (with_time)
      lines_.time_u8[i] = static_cast<std::uint8_t>(length_us > 0 ? since_us * 255 / length_us : 255);
    behind += static_cast<std::uint64_t>(ladder.count - line.k_end);
  }
  counts_[part].behind_camera = behind;
}

void Warp::vote(int part, int parts) noexcept {
  const std::int32_t first = used_ * part / parts;
  const std::int32_t last = used_ * (part + 1) / parts;
  std::uint8_t* const planes = stack_.data() + static_cast<std::size_t>(first) * pixels_;
  __builtin_memset(planes, 0, static_cast<std::size_t>(last - first) * pixels_);
  add_votes(first, last - first, part, planes);
}

void Warp::add_votes(std::int32_t first, std::int32_t count, int part, std::uint8_t* planes) noexcept {
  WarpVote vote;
  vote.u_q16 = lines_.u_q16.data();
  vote.v_q16 = lines_.v_q16.data();
  vote.du_q16 = lines_.du_q16.data();
  vote.dv_q16 = lines_.dv_q16.data();
  vote.k_end = lines_.k_end.data();
  vote.n = lines_.count;
  vote.k_begin = first;
  vote.k_count = count;
  vote.width = grid_.width_px;
  vote.height = grid_.height_px;
  vote.row_stride = grid_.width_px;
  vote.plane_stride = static_cast<std::int64_t>(pixels_);
  vote.stack = planes;
  vote.scratch = scratch_[part].data();
  counts_[part].votes += static_cast<std::uint64_t>(vote_(vote));
}

std::uint64_t Warp::votes() const noexcept {
  std::uint64_t sum = 0;
  for (int i = 0; i < parts_; ++i) sum += counts_[i].votes;
  return sum;
}

std::uint64_t Warp::behind_camera() const noexcept {
  std::uint64_t sum = 0;
  for (int i = 0; i < parts_; ++i) sum += counts_[i].behind_camera;
  return sum;
}

}  // namespace egofocus
