#include "citysim/film.hpp"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "citysim/clones.hpp"

namespace egofocus::citysim {
namespace {

constexpr std::int64_t kLongestBatchUs = 40000;  // speeds are measured at its ends and in its middle
constexpr std::int64_t kShortestStepUs = 100;
constexpr std::int64_t kLongestStepUs = 20000;
constexpr std::int64_t kFlickerStepUs = 2000;  // five exposures a period of 100 Hz
constexpr double kStep_px = 0.95;              // aimed at; the limit is 1

static_assert(Dvs::kBandRows == Optics::kTileHeight);

double seconds(std::int64_t t_us) {
  return 1e-6 * static_cast<double>(t_us);
}

/// Weights of the light and of its mains part in two views.
struct Blend {
  float before, after, mains_before, mains_after;
};

CITYSIM_CLONES void mix(const float* __restrict before, const float* __restrict after, const Blend& blend,
                        int n, float* __restrict out) {
  const Blend b = blend;
  for (int i = 0; i < n; ++i) out[i] = b.before * before[i] + b.after * after[i];
}

CITYSIM_CLONES void mix(const float* __restrict before, const float* __restrict after,
                        const float* __restrict mains_before, const float* __restrict mains_after,
                        const Blend& blend, int n, float* __restrict out) {
  const Blend b = blend;
  for (int i = 0; i < n; ++i) {
    out[i] = (b.before * before[i] + b.after * after[i]) +
             (b.mains_before * mains_before[i] + b.mains_after * mains_after[i]);
  }
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
      views_(kSteps + 1),
      start_us_(start_us) {
  scratches_.resize(kSteps + 1);
}

void Film::cut_to(std::int64_t start_us) {
  sensor_.begin_take();
  start_us_ = start_us;
  last_us_ = -1;
}

void Film::look(std::int64_t t_us) {
  const double t = seconds(t_us);
  renderer_.render(world_.camera_at(t).pose, t, scratches_[0], views_[0], {.blur = false});
  pace_ = pace_of(world_, optics_, views_[0], t_us);
}

void Film::begin(std::vector<Event>& events) {
  look(start_us_);
  ++counters_.views;
  counters_.tiles += static_cast<std::uint64_t>(optics_.tiles_across() * optics_.tiles_down());
  std::vector<float> light = views_[0].light;
  std::vector<float> spare;
  renderer_.blur(light, spare);
  const LightView first{start_us_, light, {}};
  sensor_.show({&first, 1}, workers_, events);
  last_us_ = start_us_;
}

Film::Batch Film::plan(std::int64_t t_us) const {
  const std::int64_t end_us = std::min(last_us_ + kLongestBatchUs, t_us);
  FilmPace pace = pace_;
  for (const std::int64_t later_us : {(last_us_ + end_us) / 2, end_us}) {
    const FilmPace later = pace_of(world_, optics_, views_[0], later_us);
    pace.fast = std::max(pace.fast, later.fast);
    for (std::size_t i = 0; i < pace.tile.size(); ++i) pace.tile[i] = std::max(pace.tile[i], later.tile[i]);
  }
  widen(pace, optics_);
  const double fast = std::max(1.0, pace.fast);
  const std::int64_t step_us =
      std::clamp(static_cast<std::int64_t>(1e6 * kStep_px / fast), kShortestStepUs, kLongestStepUs);
  Batch batch;
  batch.times_us[0] = last_us_;
  for (std::int64_t t = last_us_; t < end_us && batch.steps < kSteps;) {
    t = std::min(t + step_us, end_us);
    batch.times_us[++batch.steps] = t;
  }
  for (const float speed : pace.tile) {
    int stride = 1;
    while (stride < kSteps && static_cast<double>(speed) * seconds(2 * stride * step_us) <= kStep_px &&
           2 * stride * step_us <= kLongestStepUs)
      stride *= 2;
    batch.stride.push_back(stride);
  }
  return batch;
}

void Film::render(const Batch& batch) {
  // The last step is the one with most to do.
  workers_.for_each(batch.steps, [&](int i) {
    const int step = batch.steps - i;
    const std::size_t k = static_cast<std::size_t>(step);
    std::vector<std::uint8_t> wanted(batch.stride.size(), 1);
    if (step < batch.steps) {
      for (std::size_t tile = 0; tile < wanted.size(); ++tile) wanted[tile] = step % batch.stride[tile] == 0;
    }
    const double t = seconds(batch.times_us[step]);
    renderer_.render(world_.camera_at(t).pose, t, scratches_[k], views_[k],
                     {.colour = false, .blur = false, .tiles = wanted});
  });
}

void Film::expose(const Batch& batch, Exposure& exposure) const {
  const int width = optics_.width();
  const int height = optics_.height();
  const int across = optics_.tiles_across();
  const bool flickers = world_.scene.flicker_depth > 0;
  const auto flicker_at = [&](std::int64_t t_us) {
    return static_cast<float>(world_.scene.flicker_at(seconds(t_us)));
  };
  // For each stride: the two renders around, and how much of each.
  struct Around {
    const View* before;
    const View* after;
    Blend blend;
  } around[kSteps + 1] = {};
  for (int stride = 1; stride <= kSteps; stride *= 2) {
    const int before = (exposure.step - 1) / stride * stride;
    const int after = std::min(before + stride, batch.steps);
    const std::int64_t before_us = batch.times_us[before];
    const std::int64_t after_us = batch.times_us[after];
    Around& of = around[stride];
    of.before = &views_[static_cast<std::size_t>(before)];
    of.after = &views_[static_cast<std::size_t>(after)];
    const float part =
        static_cast<float>(exposure.t_us - before_us) / static_cast<float>(after_us - before_us);
    of.blend = {1.0f - part, part, 0, 0};
    if (!flickers) continue;
    const float flicker = flicker_at(exposure.t_us);
    of.blend.mains_before = of.blend.before * (flicker - flicker_at(before_us));
    of.blend.mains_after = of.blend.after * (flicker - flicker_at(after_us));
  }
  exposure.light.resize(static_cast<std::size_t>(width * height));
  for (int row = 0; row < optics_.tiles_down(); ++row) {
    const int* stride = &batch.stride[static_cast<std::size_t>(row * across)];
    for (int first = 0, next = 0; first < across; first = next) {
      while (next < across && stride[next] == stride[first]) ++next;
      const Around& of = around[stride[first]];
      const int left = first * Optics::kTileWidth;
      const int columns = std::min(next * Optics::kTileWidth, width) - left;
      const int top = row * Optics::kTileHeight;
      for (int y = top; y < std::min(top + Optics::kTileHeight, height); ++y) {
        const std::size_t at = static_cast<std::size_t>(y * width + left);
        float* light = &exposure.light[at];
        if (flickers) {
          mix(&of.before->light[at], &of.after->light[at], &of.before->mains[at], &of.after->mains[at],
              of.blend, columns, light);
        } else {
          mix(&of.before->light[at], &of.after->light[at], of.blend, columns, light);
        }
      }
    }
  }
  renderer_.blur(exposure.light, exposure.spare);
}

void Film::show(const Batch& batch, std::vector<Event>& events) {
  const std::size_t bands = static_cast<std::size_t>(optics_.tiles_down());
  std::size_t count = 0;
  const auto add = [&](std::int64_t t_us, int step) -> Exposure& {
    if (exposures_.size() == count) exposures_.emplace_back();
    Exposure& exposure = exposures_[count++];
    exposure.t_us = t_us;
    exposure.step = step;
    exposure.bands.assign(bands, 1);
    return exposure;
  };
  const bool flickers = world_.scene.flicker_depth > 0;
  for (int step = 1; step <= batch.steps; ++step) {
    const std::int64_t before_us = batch.times_us[step - 1];
    const std::int64_t t_us = batch.times_us[step];
    const std::int64_t pieces = flickers ? (t_us - before_us + kFlickerStepUs - 1) / kFlickerStepUs : 1;
    for (std::int64_t j = 1; j < pieces; ++j) add(before_us + (t_us - before_us) * j / pieces, step);
    Exposure& exposure = add(t_us, step);
    if (flickers || step == batch.steps) continue;
    // Where no tile is new, and no neighbour that blur mixes in, light only goes on as it did.
    for (std::size_t band = 0; band < bands; ++band) {
      const std::size_t across = static_cast<std::size_t>(optics_.tiles_across());
      const std::size_t first = band > 0 ? band - 1 : 0;
      const auto begin = batch.stride.begin() + static_cast<std::ptrdiff_t>(first * across);
      const auto end = batch.stride.begin() + static_cast<std::ptrdiff_t>(std::min(band + 2, bands) * across);
      exposure.bands[band] = std::any_of(begin, end, [step](int stride) { return step % stride == 0; });
    }
  }
  workers_.for_each(static_cast<int>(count),
                    [&](int i) { expose(batch, exposures_[static_cast<std::size_t>(i)]); });
  std::vector<LightView> light;
  for (std::size_t i = 0; i < count; ++i)
    light.push_back({exposures_[i].t_us, exposures_[i].light, exposures_[i].bands});
  sensor_.show(light, workers_, events);
}

void Film::count(const Batch& batch) {
  counters_.views += static_cast<std::uint64_t>(batch.steps);
  for (const int stride : batch.stride)
    counters_.tiles += static_cast<std::uint64_t>((batch.steps + stride - 1) / stride);
  // How far each tile really moved between two of its renders.
  const double step_s = seconds(batch.times_us[1] - batch.times_us[0]);
  std::size_t far = 0;
  for (std::size_t tile = 0; tile < pace_.tile.size(); ++tile)
    far +=
        static_cast<double>(pace_.tile[tile]) * step_s * batch.stride[tile] > 1.0 && batch.stride[tile] > 1;
  if (pace_.fast * step_s > 1.0 || far * 100 > pace_.tile.size())
    counters_.wide_steps += static_cast<std::uint64_t>(batch.steps);
}

void Film::run_to(std::int64_t t_us, std::vector<Event>& events) {
  if (last_us_ < 0) begin(events);
  while (last_us_ < t_us) {
    if (views_[0].inverse_depth.empty()) look(last_us_);  // restored: the last view is made again
    const Batch batch = plan(t_us);
    render(batch);
    show(batch, events);
    std::swap(views_[0], views_[static_cast<std::size_t>(batch.steps)]);
    last_us_ = batch.times_us[batch.steps];
    pace_ = pace_of(world_, optics_, views_[0], last_us_);
    count(batch);
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
  views_[0] = View{};
}

}  // namespace egofocus::citysim
