// The parts of an evaluation that need no engine. The whole is held against numpy: eval_numpy_test.py.
#include "recording/evaluation.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "recording/event_mask.hpp"

using namespace egofocus;
using namespace egofocus::recording;

namespace {

std::vector<std::int64_t> times_of(const std::vector<DepthTruth>& truth) {
  std::vector<std::int64_t> times;
  for (const DepthTruth& item : truth) times.push_back(item.t_us);
  return times;
}

}  // namespace

TEST_CASE("on a grid, truth is compared at the very time of a tick") {
  const std::vector<DepthTruth> truth{{0, ""},     {100, ""},   {33433, ""},
                                      {66766, ""}, {66767, ""}, {100100, ""}};
  // 30 Hz from 100 us: 100, 33433.3, 66766.7, 100100.
  const auto planned = [&truth](const TickGrid& grid, std::int64_t last_us) {
    SequenceScore counts;
    auto found = times_of(plan_truth(truth, grid, last_us, counts));
    CHECK(found.size() + counts.without_tick + counts.after_events + counts.same_time == truth.size());
    return found;
  };
  CHECK(planned({100, 30}, 1'000'000) == std::vector<std::int64_t>{100, 33433, 66766, 100100});
  CHECK(planned({100, 30}, 100'099) == std::vector<std::int64_t>{100, 33433, 66766});
  CHECK(planned({1, 30}, 30'000).empty());
  const std::int64_t far = std::int64_t{1} << 60;
  CHECK_FALSE(TickGrid{-far, 1000}.has(far + 1));
  CHECK_FALSE(TickGrid{far, 1000}.has(-far));
}

TEST_CASE("without a grid, all truth up to the last event is compared, each time once") {
  const std::vector<DepthTruth> truth{{-7, "-7.png"},     {0, "0.png"},      {0, "00.png"},
                                      {0, "000.png"},     {33433, "a.png"},  {50001, "b.png"},
                                      {50002, "c.png"},   {50002, "d.png"},  {100'000, "e.png"},
                                      {100'001, "f.png"}, {100'001, "g.png"}};
  SequenceScore counts;
  const std::vector<DepthTruth> planned = plan_truth(truth, {}, 100'000, counts);
  CHECK(times_of(planned) == std::vector<std::int64_t>{-7, 0, 33433, 50001, 50002, 100'000});
  CHECK(planned[1].path == "0.png");
  CHECK(planned[4].path == "c.png");
  CHECK(counts.same_time == 3);
  CHECK(counts.after_events == 2);
  CHECK(counts.without_tick == 0);
}

TEST_CASE("a pixel has an event if one of the window fell there") {
  Config config;
  config.camera.intrinsics = {4, 2, 10, 10, 1.5, 0.5};
  config.grid = {2, 2, 5, 5, 0.5, 0.5};  // half the scale: u = (x - 1.5) / 2 + 0.5
  EventMask mask(config);
  const auto at = [&mask](std::int64_t begin_us) { return mask.since(begin_us); };
  CHECK(at(0) == std::vector<std::uint8_t>{0, 0, 0, 0});
  const std::vector<Event> first{{10, 0, 0, 1}, {20, 3, 1, 0}, {21, 9, 0, 1}, {22, 0, 7, 1}};
  mask.add(first);
  CHECK(at(10) == std::vector<std::uint8_t>{1, 0, 0, 1});
  CHECK(at(11) == std::vector<std::uint8_t>{0, 0, 0, 1});
  const std::vector<Event> second{{30, 1, 0, 1}};
  mask.add(second);
  CHECK(at(11) == std::vector<std::uint8_t>{1, 0, 0, 1});
  CHECK(at(21) == std::vector<std::uint8_t>{1, 0, 0, 0});
}

TEST_CASE("the ladder reaches from half a step to its last hypothesis") {
  // Steps of 1/16 per metre, 9 hypotheses: the last is 2 m.
  CHECK(in_ladder(2.0, 0.0625, 9));
  CHECK_FALSE(in_ladder(1.99, 0.0625, 9));
  CHECK(in_ladder(32.0, 0.0625, 9));
  CHECK_FALSE(in_ladder(32.1, 0.0625, 9));
  CHECK_FALSE(in_ladder(3.0, 0, 0));
}

TEST_CASE("a frame's map keeps infinity and what is not known apart") {
  const std::uint16_t inverse[] = {0, 0, 512, 256};
  const std::uint8_t confidence[] = {0, 9, 10, 255};
  DepthFrame frame;
  frame.inverse_depth = inverse;
  frame.confidence = confidence;
  frame.inverse_depth_scale_per_m = 1.0 / 1024;
  const DepthMap map = depth_map(frame, 1);
  CHECK(map.depth_m[0] == 0);
  CHECK(std::isinf(map.depth_m[1]));
  CHECK(map.depth_m[2] == 2.0f);
  CHECK(map.depth_m[3] == 4.0f);
  CHECK(map.confidence[1] == 9);
  CHECK(depth_map(frame, 10).depth_m[1] == 0);
  CHECK(depth_map(frame, 10).depth_m[2] == 2.0f);
}

TEST_CASE("overall is the mean over all images, not over recordings") {
  const auto sequence = [](std::vector<double> errors) {
    SequenceScore score;
    score.truth_images = errors.size() + 1;
    score.without_tick = 1;
    score.after_events = 2;
    score.same_time = 3;
    score.before_events = 4;
    score.methods.resize(1);
    for (const double error : errors) {
      Metrics metrics{};
      metrics[kAbsRel] = error;
      score.methods[0].sets[kAll].add(metrics);
      score.methods[0].coverage.add(error);
      ImageFact image;
      image.step_per_m = error > 1 ? 0.1 : 0.0;
      image.pixels[kAll] = 10;
      image.pixels[kAllInLadder] = 4;
      score.images.push_back(image);
    }
    return score;
  };
  const SequenceScore all = overall({sequence({1, 2, 3}), sequence({10})});
  CHECK(all.methods[0].sets[kAll].mean()[kAbsRel] == Approx(4));
  CHECK(all.methods[0].coverage.value() == Approx(4));
  CHECK(all.truth_images == 6);
  CHECK(all.without_tick == 2);
  CHECK(all.after_events == 4);
  CHECK(all.same_time == 6);
  CHECK(all.before_events == 8);
  CHECK(all.images_without_ladder() == 1);
  CHECK(all.outside_ladder() == Approx(0.6));
  CHECK(std::isnan(sequence({1}).outside_ladder()));
}
