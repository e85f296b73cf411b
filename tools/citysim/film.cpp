#include "citysim/film.hpp"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace egofocus::citysim {
namespace {

constexpr int kBatch = 12;                       // views rendered at once
constexpr std::int64_t kLongestBatchUs = 12000;  // speeds are measured once a batch
constexpr std::int64_t kShortestStepUs = 100;
constexpr std::int64_t kLongestStepUs = 5000;
constexpr std::int64_t kFlickerStepUs = 2000;  // five views a period of 100 Hz
constexpr double kStep_px = 0.9;               // aimed at; the limit is 1

double seconds(std::int64_t t_us) {
  return 1e-6 * static_cast<double>(t_us);
}

struct Saved {
  std::int64_t last_us;
  FilmCounters counters;
};

}  // namespace

Film::Film(const World& world, const Optics& optics, Workers& workers, std::uint64_t seed,
           std::int64_t start_us)
    : world_(world),
      workers_(workers),
      optics_(optics),
      renderer_(world.scene, optics_, world.blur),
      sensor_(world.camera.intrinsics.width_px, world.camera.intrinsics.height_px, world.sensor,
              mix_bits(seed ^ 0x5e5)),
      start_us_(start_us) {
  views_.resize(kBatch);
  scratches_.resize(kBatch);
}

void Film::show_batch(std::span<const std::int64_t> times, std::vector<Event>& events) {
  workers_.for_each(static_cast<int>(times.size()), [&](int i) {
    const std::size_t k = static_cast<std::size_t>(i);
    const double t = seconds(times[k]);
    renderer_.render(world_.camera_at(t).pose, t, scratches_[k], views_[k]);
  });
  std::vector<LightView> light;
  for (std::size_t k = 0; k < times.size(); ++k) light.push_back({times[k], views_[k].light});
  sensor_.show(light, workers_, events);
  counters_.views += times.size();
  std::swap(last_, views_[times.size() - 1]);
  last_us_ = times.back();
}

double Film::fast_speed_px_s(const View& view, std::int64_t t_us) const {
  const RigidState camera = world_.camera_at(seconds(t_us));
  const Vec3& v = camera.velocity_m_s;
  const Vec3& w = camera.rate_rad_s;
  const double f = world_.camera.intrinsics.fx_px;
  std::vector<float> speeds;
  for (int row = 2; row < optics_.height(); row += 5) {
    for (int column = 2; column < optics_.width(); column += 5) {
      const Optics::Tile& tile = optics_.tile(column / Optics::kTileWidth, row / Optics::kTileHeight);
      const int in_tile = (row % Optics::kTileHeight) * Optics::kTileWidth + column % Optics::kTileWidth;
      const double x = static_cast<double>(tile.x[in_tile]);
      const double y = static_cast<double>(tile.y[in_tile]);
      const std::size_t at = static_cast<std::size_t>(row * optics_.width() + column);
      const double rho = static_cast<double>(view.inverse_depth[at]);
      // The motion field (METHOD: geometry), normalised.
      const double vx = rho * (x * v[2] - v[0]) + x * y * w[0] - (1 + x * x) * w[1] + y * w[2];
      const double vy = rho * (y * v[2] - v[1]) + (1 + y * y) * w[0] - x * y * w[1] - x * w[2];
      double speed = square_root(vx * vx + vy * vy);
      if (view.object[at] >= 0) {
        const Vec3& own = world_.scene.objects[static_cast<std::size_t>(view.object[at])].velocity_m_s;
        speed += rho * square_root(dot(own, own));
      }
      speeds.push_back(static_cast<float>(f * speed));
    }
  }
  const auto top = speeds.begin() + static_cast<std::ptrdiff_t>(speeds.size() * 99 / 100);
  std::nth_element(speeds.begin(), top, speeds.end());
  return static_cast<double>(*top);
}

void Film::run_to(std::int64_t t_us, std::vector<Event>& events) {
  if (last_us_ < 0) {
    const std::int64_t first[1] = {start_us_};
    show_batch(first, events);
  }
  const std::int64_t longest = world_.scene.flicker_depth > 0 ? kFlickerStepUs : kLongestStepUs;
  while (last_us_ < t_us) {
    if (last_.inverse_depth.empty()) {  // restored: the last view is made again
      const double t = seconds(last_us_);
      renderer_.render(world_.camera_at(t).pose, t, scratches_[0], last_);
    }
    const double now = fast_speed_px_s(last_, last_us_);
    const double soon = fast_speed_px_s(last_, std::min(last_us_ + kLongestBatchUs, t_us));
    const double speed = std::max(1.0, std::max(now, soon));
    const std::int64_t step =
        std::clamp(static_cast<std::int64_t>(1e6 * kStep_px / speed), kShortestStepUs, longest);
    std::vector<std::int64_t> times;
    for (std::int64_t t = last_us_;
         t < t_us && static_cast<int>(times.size()) < kBatch && t - last_us_ < kLongestBatchUs;) {
      t = std::min(t + step, t_us);
      times.push_back(t);
    }
    show_batch(times, events);
    if (fast_speed_px_s(last_, last_us_) * seconds(step) > 1.0) counters_.wide_steps += times.size();
  }
}

std::vector<std::uint8_t> Film::state() const {
  const Saved saved{last_us_, counters_};
  std::vector<std::uint8_t> out(sizeof saved);
  std::memcpy(out.data(), &saved, sizeof saved);
  const std::vector<std::uint8_t> sensor = sensor_.state();
  out.insert(out.end(), sensor.begin(), sensor.end());
  return out;
}

void Film::restore(std::span<const std::uint8_t> state) {
  Saved saved;
  if (state.size() < sizeof saved) throw std::invalid_argument("the saved state is cut off");
  std::memcpy(&saved, state.data(), sizeof saved);
  sensor_.restore(state.subspan(sizeof saved));
  last_us_ = saved.last_us;
  counters_ = saved.counters;
  last_ = View{};
}

}  // namespace egofocus::citysim
