// The shipped town by night, as a user would judge it: the focus backend against the exact depth.
#include <catch2/catch.hpp>
#include <filesystem>

#include "recording/evaluation.hpp"
#include "support/source_dir.hpp"

using namespace egofocus;
using namespace egofocus::recording;

TEST_CASE("the town by night has depth where it has events, and more of it where we say so", "[long]") {
  EvalOptions options;
  options.methods = {"focus+sgm", "median"};
  const SequenceScore score =
      evaluate(std::filesystem::path(test::source_dir()) / "fixtures/town5_night", options);
  CHECK(score.images.size() == 38);
  CHECK(score.images_without_ladder() == 0);
  CHECK(score.outside_ladder() < 0.1);
  const MethodScore& focus = score.methods[0];
  const MethodScore& constant = score.methods[1];
  CHECK(focus.events_coverage.value() > 0.98);
  CHECK(focus.sets[kEvents].mean()[kD1] > 0.64);
  CHECK(constant.sets[kEvents].mean()[kD1] < 0.15);
  // abs_rel of the half that our confidence ranks first, against all of it.
  const SparsificationCurve left = focus.sparsification.mean().by_confidence;
  CHECK(left[10] < 0.25 * left[0]);
}
