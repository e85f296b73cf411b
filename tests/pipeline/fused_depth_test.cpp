// Two views of one slanted plane, whose inverse depth is known in closed form in both. The first view is
// measured right, the second one wrong by so much: what comes out must be the weighted mean, wherever the
// camera went.
#include "pipeline/fused_depth.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "support/arena_block.hpp"

using namespace egofocus;

namespace {

constexpr Intrinsics kGrid{64, 48, 60, 58, 31.2, 24.1};
constexpr CellGrid kCells{32, 24};
constexpr std::int64_t kFuse_us = 400'000;
constexpr std::int64_t kTick_us = 100'000;
constexpr double kStep_per_m = 0.05;

struct Vec {
  double x, y, z;
};
/// The ray through the middle of a cell of 2x2 pixels.
Vec ray(std::int32_t x, std::int32_t y) {
  return {(2 * x + 0.5 - kGrid.cx_px) / kGrid.fx_px, (2 * y + 0.5 - kGrid.cy_px) / kGrid.fy_px, 1};
}

/// n . P = 1, in the camera's coordinates: inverse depth is n . ray.
struct Plane {
  Vec n;
  [[nodiscard]] double steps(std::int32_t x, std::int32_t y, double step_per_m) const {
    const Vec r = ray(x, y);
    return (n.x * r.x + n.y * r.y + n.z * r.z) / step_per_m;
  }
  /// As seen after P' = R P + c: n' = R n / (1 + n' . c) with n . P = 1 for all P.
  [[nodiscard]] Plane after(const MotionKnot& by) const {
    const double(&r)[9] = by.rotation;
    const Vec turned{r[0] * n.x + r[1] * n.y + r[2] * n.z, r[3] * n.x + r[4] * n.y + r[5] * n.z,
                     r[6] * n.x + r[7] * n.y + r[8] * n.z};
    const double s = 1 + turned.x * by.centre_m[0] + turned.y * by.centre_m[1] + turned.z * by.centre_m[2];
    return {{turned.x / s, turned.y / s, turned.z / s}};
  }
};
constexpr Plane kPlane{{0.05, 0.12, 0.5}};  // 2 m ahead, nearer below

MotionKnot motion(double yaw, double right_m, double ahead_m) {
  const double c = std::cos(yaw);
  const double s = std::sin(yaw);
  return {{c, 0, -s, 0, 1, 0, s, 0, c}, {-right_m, 0, -ahead_m}};
}

/// What a backend says.
struct Measured {
  std::vector<std::uint16_t> index_q8 = std::vector<std::uint16_t>(kCells.size());
  std::vector<std::uint8_t> confidence = std::vector<std::uint8_t>(kCells.size(), 200);
  std::vector<std::uint16_t> spread_q8 = std::vector<std::uint16_t>(kCells.size() / 4);
  Measured(const Plane& plane, double wrong_steps, double spread_steps, double step_per_m = kStep_per_m) {
    for (std::int32_t y = 0; y < kCells.height; ++y) {
      for (std::int32_t x = 0; x < kCells.width; ++x) {
        const double steps = plane.steps(x, y, step_per_m) + wrong_steps;
        index_q8[static_cast<std::size_t>(y * kCells.width + x)] =
            static_cast<std::uint16_t>(std::lround(256 * steps));
      }
    }
    std::fill(spread_q8.begin(), spread_q8.end(),
              static_cast<std::uint16_t>(std::lround(256 * spread_steps)));
  }
  [[nodiscard]] CellDepth cells() const { return {kCells, index_q8, confidence, false, spread_q8}; }
};

/// A FusedDepth with its memory and workers.
class Fuser {
 public:
  explicit Fuser(int threads = 1) {
    if (threads > 1) REQUIRE(pool_.start(threads, 0, -1).ok());
  }
  CellDepth add(const Measured& measured, std::int64_t t_us, const MotionKnot* since,
                double step_per_m = kStep_per_m) {
    return fused.fuse(measured.cells(), step_per_m, t_us, since, pool_);
  }

 private:
  test::RoomyArena arena_;
  WorkerPool pool_;

 public:
  FusedDepth fused{config(), kGrid, *arena_};

 private:
  static CarryConfig config() {
    CarryConfig config;
    config.fuse_us = kFuse_us;
    return config;
  }
};

/// Largest |index - expected| in steps over the cells at least `margin` from the border, and how many there
/// are.
struct Off {
  double most_steps = 0;
  int cells = 0;
};
template <typename Expected>
Off off(const CellDepth& cells, std::int32_t margin, const Expected& expected) {
  Off out;
  for (std::int32_t y = margin; y < kCells.height - margin; ++y) {
    for (std::int32_t x = margin; x < kCells.width - margin; ++x) {
      const double index = cells.index_q8[static_cast<std::size_t>(y * kCells.width + x)] / 256.0;
      out.most_steps = std::max(out.most_steps, std::abs(index - expected(x, y)));
      ++out.cells;
    }
  }
  return out;
}

// Where a point lies between two cells the nearer one answers: half a cell of the plane's slope, and
// rounding.
constexpr double kNearestCell_steps = 0.1;

}  // namespace

TEST_CASE("the weighted mean of two measurements, wherever the camera went between them") {
  const MotionKnot ways[] = {motion(0, 0, 0),    motion(0, 0.1, 0),  motion(0, 0, 0.3),
                             motion(0, 0, -0.3), motion(0.06, 0, 0), motion(-0.04, 0.08, 0.25)};
  for (const MotionKnot& way : ways) {
    CAPTURE(way.centre_m[0], way.centre_m[2], way.rotation[6]);
    for (const double now_spread : {1.0, 2.0, 6.0}) {
      Fuser fuser;
      fuser.add(Measured(kPlane, 0, 1), 0, nullptr);
      REQUIRE(fuser.fused.kept_at(kTick_us));
      REQUIRE(fuser.fused.seen_us() == 0);
      const Plane here = kPlane.after(way);
      const double wrong = 0.8;
      const CellDepth cells = fuser.add(Measured(here, wrong, now_spread), kTick_us, &way);
      const double earlier_weight = 1 - static_cast<double>(kTick_us) / kFuse_us;
      const double weight = 1 / (now_spread * now_spread);
      const double left = wrong * weight / (weight + earlier_weight);
      const Off found =
          off(cells, 6, [&](std::int32_t x, std::int32_t y) { return here.steps(x, y, kStep_per_m) + left; });
      CHECK(found.cells == 20 * 12);
      CHECK(found.most_steps < kNearestCell_steps);
    }
  }
}

TEST_CASE("each 2x2 cells have their own spread") {
  const MotionKnot still = motion(0, 0, 0);
  Fuser fuser;
  fuser.add(Measured(kPlane, 0, 1), 0, nullptr);
  Measured now(kPlane, 1, 1);
  for (std::size_t i = 0; i < now.spread_q8.size(); ++i)
    now.spread_q8[i] = static_cast<std::uint16_t>(256 * (1 + (i / 16 + i) % 3));
  const CellDepth cells = fuser.add(now, kTick_us, &still);
  const Off found = off(cells, 0, [&](std::int32_t x, std::int32_t y) {
    const double spread = 1 + (y / 2 + x / 2 + (y / 2) * 16) % 3;
    const double weight = 1 / (spread * spread);
    return kPlane.steps(x, y, kStep_per_m) + weight / (weight + 0.75);
  });
  CHECK(found.most_steps < 0.02);
}

TEST_CASE("another tick's ladder has other steps") {
  for (const double step_per_m : {kStep_per_m / 2, kStep_per_m, kStep_per_m * 3}) {
    CAPTURE(step_per_m);
    Fuser fuser;
    fuser.add(Measured(kPlane, 0, 1, step_per_m), 0, nullptr, step_per_m);
    const MotionKnot still = motion(0, 0, 0);
    const CellDepth cells = fuser.add(Measured(kPlane, 0.9, 2), kTick_us, &still);
    const double earlier_spread = step_per_m / kStep_per_m;
    const double earlier_weight = 0.75 / (earlier_spread * earlier_spread);
    const double left = 0.9 * 0.25 / (0.25 + earlier_weight);
    const Off found =
        off(cells, 0, [&](std::int32_t x, std::int32_t y) { return kPlane.steps(x, y, kStep_per_m) + left; });
    CHECK(found.most_steps < 0.02);
  }
}

TEST_CASE("what contradicts the earlier depth stands alone, and the earlier depth is forgotten") {
  const MotionKnot still = motion(0, 0, 0);
  // 3 sigma of spreads 1 and 1 / sqrt(.75): 4.58 steps.
  for (const double wrong : {4.4, 4.8}) {
    CAPTURE(wrong);
    Fuser fuser;
    fuser.add(Measured(kPlane, 0, 1), 0, nullptr);
    const CellDepth cells = fuser.add(Measured(kPlane, wrong, 1), kTick_us, &still);
    const double expected = wrong < 4.5 ? wrong / 1.75 : wrong;
    const Off found = off(
        cells, 0, [&](std::int32_t x, std::int32_t y) { return kPlane.steps(x, y, kStep_per_m) + expected; });
    CHECK(found.most_steps < 0.02);
  }
}

TEST_CASE("earlier depth ends with its time, with a break in the motion and at the edge of what was seen") {
  const MotionKnot still = motion(0, 0, 0);
  const auto alone = [](double wrong) {
    return [wrong](std::int32_t x, std::int32_t y) { return kPlane.steps(x, y, kStep_per_m) + wrong; };
  };
  Fuser fuser;
  CHECK_FALSE(fuser.fused.kept_at(0));
  fuser.add(Measured(kPlane, 0, 1), 0, nullptr);
  CHECK(fuser.fused.kept_at(kFuse_us - 1));
  CHECK_FALSE(fuser.fused.kept_at(kFuse_us));
  CHECK(off(fuser.add(Measured(kPlane, 1, 1), kFuse_us, &still), 0, alone(1)).most_steps < 0.01);
  CHECK(off(fuser.add(Measured(kPlane, 2, 1), kFuse_us + kTick_us, nullptr), 0, alone(2)).most_steps < 0.01);

  // To the right by a third of the picture: what comes in there was not seen before.
  const MotionKnot turn = motion(0.35, 0, 0);
  fuser.add(Measured(kPlane, 0, 1), 0, nullptr);
  const Plane here = kPlane.after(turn);
  const CellDepth cells = fuser.add(Measured(here, 1, 1), kTick_us, &turn);
  int as_measured = 0;
  for (std::int32_t x = 0; x < kCells.width; ++x) {
    const double index = cells.index_q8[static_cast<std::size_t>(12 * kCells.width + x)] / 256.0;
    as_measured += std::abs(index - here.steps(x, 12, kStep_per_m) - 1) < 0.01 ? 1 : 0;
  }
  CHECK(as_measured > 8);
  CHECK(as_measured < 15);
}

TEST_CASE(
    "confidence is that of the fused spread, and a cell without an estimate has none and is forgotten") {
  const MotionKnot still = motion(0, 0, 0);
  Fuser fuser;
  Measured first(kPlane, 0, 2);
  first.confidence[5] = 0;
  const CellDepth alone = fuser.add(first, 0, nullptr);
  CHECK(alone.confidence[0] == 200);
  CHECK(alone.confidence[5] == 0);
  Measured second(kPlane, 0, 2);
  second.confidence[7] = 0;
  const CellDepth both = fuser.add(second, kTick_us, &still);
  const double spread = 2 / std::sqrt(1.75);
  const double index = both.index_q8[40] / 256.0;
  CHECK(both.confidence[40] == Approx(255 * index / (index + spread)).margin(1.5));
  CHECK(both.confidence[5] == 200);
  CHECK(both.confidence[7] == 0);
  const CellDepth third = fuser.add(Measured(kPlane, 1, 2), 2 * kTick_us, &still);
  CHECK(third.index_q8[7] / 256.0 == Approx(kPlane.steps(7, 0, kStep_per_m) + 1).margin(0.01));
}

TEST_CASE("extreme cells stay within their types") {
  const MotionKnot way = motion(0.02, 0.02, 0.05);
  for (const int index : {0, 1, 65535}) {
    for (const int spread : {0, 1, 65535}) {
      Fuser fuser;
      Measured measured(kPlane, 0, 1);
      std::fill(measured.index_q8.begin(), measured.index_q8.end(), static_cast<std::uint16_t>(index));
      std::fill(measured.spread_q8.begin(), measured.spread_q8.end(), static_cast<std::uint16_t>(spread));
      for (int tick = 0; tick < 40; ++tick) {
        const CellDepth cells = fuser.add(measured, tick * kTick_us, tick > 0 ? &way : nullptr);
        CHECK(*std::min_element(cells.confidence.begin(), cells.confidence.end()) >= 1);
        const auto [least, most] = std::minmax_element(cells.index_q8.begin(), cells.index_q8.end());
        CHECK(*most - *least <= (index > 1 ? 65535 / 8 : 1));
      }
    }
  }
}

TEST_CASE("the same bytes on any number of threads") {
  const MotionKnot way = motion(-0.04, 0.08, 0.25);
  std::vector<std::uint16_t> one;
  for (const int threads : {1, 2, 4}) {
    Fuser fuser(threads);
    fuser.add(Measured(kPlane, 0, 1), 0, nullptr);
    const CellDepth cells = fuser.add(Measured(kPlane.after(way), 1, 1), kTick_us, &way);
    if (one.empty()) one.assign(cells.index_q8.begin(), cells.index_q8.end());
    CHECK(std::equal(one.begin(), one.end(), cells.index_q8.begin(), cells.index_q8.end()));
  }
}
