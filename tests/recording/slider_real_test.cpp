// The real slider recording through the whole pipeline, against the reference depth beside it. The recording
// is read in place; where it is not there, the test says so.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <numeric>
#include <string>
#include <vector>

#include "recording/convert_ecd.hpp"
#include "recording/replay.hpp"
#include "recording/temporary_folder.hpp"
#include "support/npz.hpp"
#include "support/source_dir.hpp"

using namespace egofocus;
using namespace egofocus::recording;

namespace {

constexpr std::int64_t kReference_us = 174'156;  // t_ref of the protocol: the last event
constexpr std::size_t kConfident = 7000;

std::filesystem::path slider_folder() {
  const char* given = std::getenv("EGOFOCUS_REAL_DATA");
  return std::filesystem::path(given ? given : egofocus::test::source_dir() + "/../shared/real") /
         "slider_depth";
}

struct Score {
  double median = 0;
  double within_10_percent = 0;
  double d1 = 0;
};

// A reference pixel without an estimate is an error of 100 %.
Score score(const std::vector<float>& estimate, const std::vector<float>& reference,
            const std::vector<std::size_t>& pixels) {
  std::vector<double> errors;
  Score s;
  for (const std::size_t i : pixels) {
    const double d = static_cast<double>(estimate[i]);
    const double g = static_cast<double>(reference[i]);
    const double e = d > 0 ? std::abs(d - g) / g : 1.0;
    errors.push_back(e);
    s.within_10_percent += e <= 0.1;
    s.d1 += d > 0 && std::max(d / g, g / d) < 1.25;
  }
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2),
                   errors.end());
  const auto n = static_cast<double>(pixels.size());
  return {errors[errors.size() / 2], s.within_10_percent / n, s.d1 / n};
}

struct Outcome {
  Score all;
  Score confident;
  double coverage = 0;  // of the reference pixels
  Health health;
};

Outcome replay_slider(const std::filesystem::path& recording, FocusCost cost, std::int64_t max_age_us,
                      const std::vector<float>& reference) {
  Folder folder = open_folder(recording);
  folder.camera.config.backend = Backend::kFocus;
  folder.camera.config.focus.cost = cost;
  folder.camera.config.window.max_age_us = max_age_us;
  Replay replay(std::move(folder));
  replay.start(kReference_us);
  DepthFrame frame;
  REQUIRE(replay.tick(frame));
  REQUIRE(frame.t_us == kReference_us);
  CHECK(frame.flags == 0);
  std::vector<float> depth(frame.inverse_depth.size());
  metric_depth(frame, 100.0f, depth);
  std::vector<std::size_t> pixels;
  for (std::size_t i = 0; i < reference.size(); ++i) {
    if (reference[i] > 0) pixels.push_back(i);
  }
  REQUIRE(pixels.size() == 8950);
  Outcome outcome;
  outcome.all = score(depth, reference, pixels);
  outcome.coverage = static_cast<double>(std::count_if(pixels.begin(), pixels.end(),
                                                       [&](std::size_t i) { return depth[i] > 0; })) /
                     static_cast<double>(pixels.size());
  std::stable_sort(pixels.begin(), pixels.end(),
                   [&](std::size_t a, std::size_t b) { return frame.confidence[a] > frame.confidence[b]; });
  pixels.resize(kConfident);
  outcome.confident = score(depth, reference, pixels);
  outcome.health = replay.engine().health();
  return outcome;
}

void print(const char* what, const Outcome& o) {
  std::printf(
      "slider %-22s all: median %.2f %%, within 10 %% %.1f %%, d1 %.3f; 7,000 most confident: %.2f %%, %.1f "
      "%%, %.3f; "
      "coverage %.1f %%\n",
      what, 100 * o.all.median, 100 * o.all.within_10_percent, o.all.d1, 100 * o.confident.median,
      100 * o.confident.within_10_percent, o.confident.d1, 100 * o.coverage);
}

}  // namespace

TEST_CASE("real events: the slider's depth reaches the published sweep and beyond") {
  const std::filesystem::path real = slider_folder();
  if (!std::filesystem::exists(real)) {
    WARN("skipped: no " << real.string() << " (set EGOFOCUS_REAL_DATA to the folder that has slider_depth/)");
    return;
  }
  const auto truth_file = real / "ref_depth_at_0.174156.npz";
  std::vector<float> reference = test::npz_array<float>(truth_file, "depth");
  const std::vector<std::uint8_t> valid = test::npz_array<std::uint8_t>(truth_file, "valid");
  REQUIRE(valid.size() == reference.size());
  for (std::size_t i = 0; i < valid.size(); ++i) {
    if (!valid[i]) reference[i] = 0;
  }
  const TemporaryFolder folder;
  ConvertOptions options;
  options.z_near_m = 0.4;
  REQUIRE(convert_ecd(real, folder / "slider", options).events == 50000);

  const Outcome best = replay_slider(folder / "slider", FocusCost::kGradient, 200'000, reference);
  print("gradient", best);
  CHECK(best.all.median <= 0.020);
  CHECK(best.all.within_10_percent >= 0.87);
  CHECK(best.all.d1 >= 0.93);
  CHECK(best.confident.median <= 0.015);
  CHECK(best.confident.within_10_percent >= 0.96);
  // The events before the first pose (22,291 us) are no error, but they are counted.
  CHECK(best.health.window.outside_motion == 3251);
  CHECK(best.health.events.kept == 50000);

  const struct {
    FocusCost cost;
    const char* name;
  } others[] = {{FocusCost::kVariance, "variance"},
                {FocusCost::kSosa, "sosa"},
                {FocusCost::kSoe, "soe"},
                {FocusCost::kSti, "sti"}};
  for (const auto& other : others) {
    const Outcome outcome = replay_slider(folder / "slider", other.cost, 200'000, reference);
    print(other.name, outcome);
    CHECK(outcome.all.d1 >= 0.90);  // none of them is broken
  }
  print("gradient, from 0.085 s", replay_slider(folder / "slider", FocusCost::kGradient, 89'156, reference));
}
