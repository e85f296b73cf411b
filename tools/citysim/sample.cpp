#include "citysim/sample.hpp"

#include <algorithm>
#include <bit>

#include "citysim/true_ladder.hpp"

namespace egofocus::citysim {
namespace {

constexpr std::int64_t kWarmUpUs = 10000;  // the low pass forgets how it began

constexpr double kFullParallax_px = 36;  // of the 40 that the library's ladder spans

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
  for (int n = 0; n < count; ++n) {
    std::int64_t end_us = 0;
    HypothesisLadder ladder;
    const int tries = random.chance(0.9) ? 12 : 1;
    const double enough_px = random.chance(0.85) ? kFullParallax_px : 0;
    for (int i = 0; i < tries; ++i) {
      const auto at_us = static_cast<std::int64_t>(1e6 * random.uniform(0.3, duration_s - 0.05));
      const HypothesisLadder tried = true_ladder(world, at_us);
      if (i == 0 || tried.parallax_px > ladder.parallax_px) {
        end_us = at_us;
        ladder = tried;
      }
      if (tried.has_parallax && tried.parallax_px >= enough_px) break;
    }
    Sample sample;
    sample.family = world.family;
    sample.night = world.night;
    sample.seed = seed;
    sample.at_us = end_us;
    sample.z_near_m = world.z_near_m;
    sample.camera = world.camera;
    const std::int64_t begin_us = std::max(ladder.begin_us, end_us - kLongestWindowUs);
    sample.window_us = static_cast<std::int32_t>(end_us - begin_us);

    film.cut_to(std::max<std::int64_t>(0, begin_us - kWarmUpUs));
    film.run_to(end_us, sample.events);
    film.finish(sample.events);
    std::erase_if(sample.events,
                  [&](const Event& event) { return event.t_us < begin_us || event.t_us > end_us; });
    for (Event& event : sample.events) event.t_us -= end_us;

    for (int i = 0; i < Sample::kMotions; ++i) {
      SampleMotion& motion = sample.motion[static_cast<std::size_t>(i)];
      motion.t_us =
          static_cast<std::int32_t>(-kLongestWindowUs + kLongestWindowUs * i / (Sample::kMotions - 1));
      const RigidState state = world.camera_at(1e-6 * static_cast<double>(end_us + motion.t_us));
      for (std::size_t k = 0; k < 3; ++k) {
        motion.velocity_m_s[k] = static_cast<float>(state.velocity_m_s[k]);
        motion.rate_rad_s[k] = static_cast<float>(state.rate_rad_s[k]);
      }
    }
    const double t_s = 1e-6 * static_cast<double>(end_us);
    truth.render(world.camera_at(t_s).pose, t_s, scratch, view);
    sample.inverse_depth = view.inverse_depth;
    sample.moving.resize(view.object.size());
    for (std::size_t i = 0; i < view.object.size(); ++i) {
      if (view.object[i] < 0) continue;
      const Vec3& v = world.scene.objects[static_cast<std::size_t>(view.object[i])].velocity_m_s;
      sample.moving[i] = dot(v, v) > 0;
    }
    out.push_back(std::move(sample));
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
