#include "citysim/sample.hpp"

#include <algorithm>
#include <bit>

namespace egofocus::citysim {
namespace {

constexpr std::int64_t kWarmUpUs = 10000;  // the low pass forgets how it began

constexpr int kTakeWindows = 3;  // filmed in one go
constexpr double kEarliest_s = 1e-6 * (kLongestWindowUs + kWarmUpUs);

class Bytes {
 public:
  template <typename Value>
  void put(Value value) {
    if constexpr (std::is_floating_point_v<Value>) {
      using Word = std::conditional_t<sizeof(Value) == 4, std::uint32_t, std::uint64_t>;
      put(std::bit_cast<Word>(value));
    } else {
      for (std::size_t i = 0; i < sizeof(Value); ++i) {
        bytes_.push_back(static_cast<std::byte>((static_cast<std::uint64_t>(value) >> (8 * i)) & 0xff));
      }
    }
  }
  [[nodiscard]] std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

/// When a window ends, and the ladder that the library would choose for it.
struct WindowEnd {
  std::int64_t end_us = 0;
  HypothesisLadder ladder;

  [[nodiscard]] std::int64_t begin_us() const { return std::max(ladder.begin_us, end_us - kLongestWindowUs); }
};

WindowEnd window_end(const World& world, std::int64_t end_us) {
  return {end_us, true_ladder(world, end_us)};
}

/// A random time, preferably one with parallax, often one whose parallax fills the ladder.
WindowEnd draw_end(const World& world, double duration_s, Random& random) {
  const int tries = random.chance(0.9) ? 12 : 1;
  const double enough_px = random.chance(0.4) ? kFullParallax_px : 0;
  WindowEnd best;
  for (int i = 0; i < tries; ++i) {
    const auto at_us = static_cast<std::int64_t>(1e6 * random.uniform(kEarliest_s, duration_s - 0.3));
    const WindowEnd tried = window_end(world, at_us);
    if (i == 0 || tried.ladder.parallax_px > best.ladder.parallax_px) best = tried;
    if (tried.ladder.has_parallax && tried.ladder.parallax_px >= enough_px) break;
  }
  return best;
}

/// The next one of a take that began at `begin_us`: later by 0.3 to 0.5 of the window.
WindowEnd draw_next(const World& world, const WindowEnd& last, std::int64_t begin_us, Random& random) {
  const double length_us = static_cast<double>(last.end_us - last.begin_us());
  const auto later_us = static_cast<std::int64_t>(random.uniform(0.3, 0.5) * length_us);
  WindowEnd next = window_end(world, last.end_us + later_us);
  next.ladder.begin_us = std::max(next.begin_us(), begin_us);
  return next;
}

Sample make_sample(const World& world, std::uint64_t seed, const WindowEnd& window,
                   std::span<const Event> filmed, const View& truth) {
  Sample sample;
  sample.family = world.family;
  sample.night = world.night;
  sample.seed = seed;
  sample.at_us = window.end_us;
  sample.z_near_m = world.z_near_m;
  sample.camera = world.camera;
  sample.window_us = static_cast<std::int32_t>(window.end_us - window.begin_us());
  for (Event event : filmed) {
    if (event.t_us < window.begin_us() || event.t_us > window.end_us) continue;
    event.t_us -= window.end_us;
    sample.events.push_back(event);
  }
  for (int i = 0; i < Sample::kMotions; ++i) {
    SampleMotion& motion = sample.motion[static_cast<std::size_t>(i)];
    motion.t_us =
        static_cast<std::int32_t>(-kLongestWindowUs + kLongestWindowUs * i / (Sample::kMotions - 1));
    const RigidState state = world.camera_at(1e-6 * static_cast<double>(window.end_us + motion.t_us));
    for (std::size_t k = 0; k < 3; ++k) {
      motion.velocity_m_s[k] = static_cast<float>(state.velocity_m_s[k]);
      motion.rate_rad_s[k] = static_cast<float>(state.rate_rad_s[k]);
    }
  }
  sample.inverse_depth = truth.inverse_depth;
  sample.moving.resize(truth.object.size());
  for (std::size_t i = 0; i < truth.object.size(); ++i) {
    if (truth.object[i] < 0) continue;
    const Vec3& v = world.scene.objects[static_cast<std::size_t>(truth.object[i])].velocity_m_s;
    sample.moving[i] = dot(v, v) > 0;
  }
  return sample;
}

}  // namespace

std::vector<Sample> draw_samples(const World& world, std::uint64_t seed, double duration_s, int count,
                                 Workers& workers) {
  const Optics optics(world.camera);
  const Optics grid(CameraModel{world.grid, Distortion::kNone, {}});
  const Renderer truth(world.scene, grid, 0);
  RenderScratch scratch;
  View view;
  Film film(world, optics, workers, mix_bits(seed));
  Random random(seed, "samples");
  std::vector<Sample> out;
  while (static_cast<int>(out.size()) < count) {
    const WindowEnd first = draw_end(world, duration_s, random);
    std::vector<WindowEnd> windows{first};
    const int left = count - static_cast<int>(out.size());
    for (int i = 1; i < std::min(left, kTakeWindows); ++i)
      windows.push_back(draw_next(world, windows.back(), first.begin_us(), random));
    std::vector<Event> events;
    film.cut_to(std::max<std::int64_t>(0, first.begin_us() - kWarmUpUs));
    for (const WindowEnd& window : windows) film.run_to(window.end_us, events);
    film.finish(events);
    for (const WindowEnd& window : windows) {
      const double t_s = 1e-6 * static_cast<double>(window.end_us);
      truth.render(world.camera_at(t_s).pose, t_s, scratch, view);
      out.push_back(make_sample(world, seed, window, events, view));
    }
  }
  return out;
}

std::vector<std::byte> sample_bytes(const Sample& sample) {
  Bytes out;
  out.put(sample.seed);
  out.put(sample.at_us);
  out.put(static_cast<std::uint8_t>(sample.family));
  out.put(static_cast<std::uint8_t>(sample.night));
  const Intrinsics& in = sample.camera.intrinsics;
  out.put(static_cast<std::uint16_t>(in.width_px));
  out.put(static_cast<std::uint16_t>(in.height_px));
  out.put(static_cast<std::uint16_t>(sample.camera.distortion));
  for (const double value : {in.fx_px, in.fy_px, in.cx_px, in.cy_px}) out.put(value);
  for (const double value : sample.camera.coefficients) out.put(value);
  out.put(sample.z_near_m);
  out.put(sample.window_us);
  out.put(static_cast<std::uint32_t>(sample.events.size()));
  for (const SampleMotion& motion : sample.motion) {
    out.put(motion.t_us);
    for (const float value : motion.velocity_m_s) out.put(value);
    for (const float value : motion.rate_rad_s) out.put(value);
  }
  for (const Event& event : sample.events) {
    out.put(static_cast<std::int32_t>(event.t_us));
    out.put(event.x);
    out.put(static_cast<std::uint16_t>(event.y | (event.polarity != 0 ? 0x8000u : 0u)));
  }
  const float largest = *std::max_element(sample.inverse_depth.begin(), sample.inverse_depth.end());
  const float step = largest > 0 ? largest / 65535.0f : 1.0f;
  out.put(step);
  for (const float rho : sample.inverse_depth) {
    const float code = rho / step + 0.5f;
    out.put(static_cast<std::uint16_t>(rho > 0 ? std::clamp(code, 1.0f, 65535.0f) : 0.0f));
  }
  for (const std::uint8_t moving : sample.moving) out.put(moving);
  return out.take();
}

}  // namespace egofocus::citysim
