// Frames, depth and events of a recording lie in one geometry: events come from edges that move, so the
// places where they land on the grid, found by this file's own undistortion, lie on edges of the frame and of
// the depth of the same time. How well they do, as a function of an artificial shift, is best without any.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "citysim/recording_writer.hpp"
#include "recording/event_reader.hpp"
#include "recording/folder.hpp"
#include "recording/png_io.hpp"
#include "recording/temporary_folder.hpp"

using namespace egofocus;
using namespace egofocus::citysim;
using recording::Picture;

namespace {

// An event may be early or late by this much: as often as not, so that motion moves none of the peaks.
constexpr std::int64_t kAround_us = 4000;
constexpr int kReach = 8;  // half pixels
constexpr int kSide = 2 * kReach + 1;
constexpr int kTiles = 3;  // across, and down

struct GridPlace {
  double u, v;
};

/// Plumb-bob inverted by fixed-point steps, and onto the grid.
GridPlace undistorted(const CameraModel& camera, const Intrinsics& grid, const Event& event) {
  const Intrinsics& in = camera.intrinsics;
  const auto& k = camera.coefficients;
  const double x0 = (event.x - in.cx_px) / in.fx_px;
  const double y0 = (event.y - in.cy_px) / in.fy_px;
  double x = x0;
  double y = y0;
  for (int i = 0; i < 50; ++i) {
    const double r2 = x * x + y * y;
    const double radial = 1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
    const double dx = 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x);
    const double dy = k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y;
    x = (x0 - dx) / radial;
    y = (y0 - dy) / radial;
  }
  return {x * grid.fx_px + grid.cx_px, y * grid.fy_px + grid.cy_px};
}

GridPlace as_it_is(const CameraModel&, const Intrinsics&, const Event& event) {
  return {static_cast<double>(event.x), static_cast<double>(event.y)};
}

Picture<float> frame_edges(const recording::GreyPicture& frame) {
  Picture<float> out(frame.width_px, frame.height_px);
  for (int y = 1; y + 1 < frame.height_px; ++y) {
    for (int x = 1; x + 1 < frame.width_px; ++x) {
      const double across = frame.at(x + 1, y) - frame.at(x - 1, y);
      const double down = frame.at(x, y + 1) - frame.at(x, y - 1);
      out.at(x, y) = static_cast<float>(std::min(std::hypot(across, down), 100.0));
    }
  }
  return out;
}

/// Second differences of the inverse depth, relative, at most 0.2: 0 on planes, whichever way they lean.
Picture<float> depth_edges(const Picture<float>& depth_m) {
  Picture<float> out(depth_m.width_px, depth_m.height_px);
  for (int y = 1; y + 1 < depth_m.height_px; ++y) {
    for (int x = 1; x + 1 < depth_m.width_px; ++x) {
      const auto rho = [&](int i, int j) { return 1.0 / static_cast<double>(depth_m.at(x + i, y + j)); };
      const double nearest = std::max({rho(0, 0), rho(1, 0), rho(-1, 0), rho(0, 1), rho(0, -1)});
      if (!(nearest > 0)) continue;
      const double bend =
          std::hypot(rho(1, 0) + rho(-1, 0) - 2 * rho(0, 0), rho(0, 1) + rho(0, -1) - 2 * rho(0, 0));
      out.at(x, y) = static_cast<float>(std::min(bend / nearest, 0.2));
    }
  }
  return out;
}

/// Mean edge strength under all events, for each shift of the events by half pixels.
class Landscape {
 public:
  void add(const Picture<float>& edge, const GridPlace& at) {
    for (int j = 0; j < kSide; ++j) {
      for (int i = 0; i < kSide; ++i) {
        sums_[static_cast<std::size_t>(j * kSide + i)] +=
            sample(edge, at.u + 0.5 * (i - kReach), at.v + 0.5 * (j - kReach));
      }
    }
    ++events_;
  }
  [[nodiscard]] std::size_t events() const { return events_; }
  [[nodiscard]] double at(int i, int j) const {
    return sums_[static_cast<std::size_t>((j + kReach) * kSide + i + kReach)] / static_cast<double>(events_);
  }
  /// Where the peak is, in pixels, between the half pixels by a parabola.
  [[nodiscard]] GridPlace best() const {
    int bi = 0;
    int bj = 0;
    for (int j = -kReach; j <= kReach; ++j) {
      for (int i = -kReach; i <= kReach; ++i) {
        if (at(i, j) > at(bi, bj)) {
          bi = i;
          bj = j;
        }
      }
    }
    const auto between = [](double before, double here, double after) {
      return (before - after) / (2 * (before - 2 * here + after));
    };
    GridPlace out{0.5 * bi, 0.5 * bj};
    if (std::abs(bi) < kReach) out.u += 0.5 * between(at(bi - 1, bj), at(bi, bj), at(bi + 1, bj));
    if (std::abs(bj) < kReach) out.v += 0.5 * between(at(bi, bj - 1), at(bi, bj), at(bi, bj + 1));
    return out;
  }
  /// How far the peak is off in the direction in which the landscape bends most: along an edge nothing tells.
  [[nodiscard]] double across_px() const {
    const double uu = at(2, 0) + at(-2, 0) - 2 * at(0, 0);
    const double vv = at(0, 2) + at(0, -2) - 2 * at(0, 0);
    const double uv = (at(2, 2) + at(-2, -2) - at(2, -2) - at(-2, 2)) / 4;
    const double along =
        0.5 * std::atan2(2 * uv, uu - vv);  // the direction of the least bend: a peak's are negative
    const GridPlace peak = best();
    return std::abs(peak.v * std::cos(along) - peak.u * std::sin(along));
  }
  /// At the peak, over the mean of the rim.
  [[nodiscard]] double prominence() const {
    double rim = 0;
    int count = 0;
    double peak = 0;
    for (int j = -kReach; j <= kReach; ++j) {
      for (int i = -kReach; i <= kReach; ++i) {
        peak = std::max(peak, at(i, j));
        if (std::abs(i) < kReach && std::abs(j) < kReach) continue;
        rim += at(i, j);
        ++count;
      }
    }
    return peak / (rim / count);
  }

 private:
  static double sample(const Picture<float>& edge, double u, double v) {
    const int x = static_cast<int>(std::floor(u));
    const int y = static_cast<int>(std::floor(v));
    if (x < 0 || y < 0 || x + 1 >= edge.width_px || y + 1 >= edge.height_px) return 0;
    const double a = u - x;
    const double b = v - y;
    const auto value = [&edge](int i, int j) { return static_cast<double>(edge.at(i, j)); };
    return (1 - b) * ((1 - a) * value(x, y) + a * value(x + 1, y)) +
           b * ((1 - a) * value(x, y + 1) + a * value(x + 1, y + 1));
  }

  std::array<double, kSide * kSide> sums_{};
  std::size_t events_ = 0;
};

struct Found {
  Landscape all;
  std::array<Landscape, kTiles * kTiles> tiles;
  /// The farthest best shift of the tiles with enough events and a clear peak; how many those are.
  [[nodiscard]] double worst_tile_px() const {
    double worst = 0;
    for (const Landscape& tile : tiles) {
      if (is_clear(tile)) worst = std::max(worst, tile.across_px());
    }
    return worst;
  }
  [[nodiscard]] int clear_tiles() const {
    return static_cast<int>(std::count_if(tiles.begin(), tiles.end(), is_clear));
  }
  static bool is_clear(const Landscape& tile) { return tile.events() > 300 && tile.prominence() > 1.3; }
};

/// Within the reach of the shifts, on all sides alike.
bool is_near_edge(const Picture<float>& edge, const GridPlace& at) {
  const int x = static_cast<int>(std::lround(at.u));
  const int y = static_cast<int>(std::lround(at.v));
  constexpr int kRadius = kReach / 2;
  for (int j = std::max(y - kRadius, 0); j <= std::min(y + kRadius, edge.height_px - 1); ++j) {
    for (int i = std::max(x - kRadius, 0); i <= std::min(x + kRadius, edge.width_px - 1); ++i) {
      if (edge.at(i, j) > 0.1f) return true;
    }
  }
  return false;
}

struct Both {
  Found frame;
  Found depth;
};

template <typename Mapping>
Both correlate(const recording::Folder& folder, Mapping place_of) {
  const Config& config = folder.camera.config;
  RawHeader header;
  REQUIRE(parse_raw_header(folder.events.bytes(), header).ok());
  recording::EventReader events(folder.events.bytes(), header);
  Both found;
  for (const recording::DepthTruth& truth : folder.truth) {
    const Picture<float> of_frame =
        frame_edges(recording::read_grey_png(folder.path / "pictures/grey" / truth.path.filename()));
    const Picture<float> of_depth = depth_edges(recording::read_depth(truth, folder.camera));
    for (const Event& event : events.between(truth.t_us - kAround_us, truth.t_us + kAround_us)) {
      const GridPlace at = place_of(config.camera, config.grid, event);
      const int column = static_cast<int>(at.u * kTiles / config.grid.width_px);
      const int row = static_cast<int>(at.v * kTiles / config.grid.height_px);
      if (!(at.u >= 0 && at.v >= 0) || column >= kTiles || row >= kTiles) continue;
      const auto tile = static_cast<std::size_t>(row * kTiles + column);
      found.frame.all.add(of_frame, at);
      found.frame.tiles[tile].add(of_frame, at);
      if (!is_near_edge(of_depth, at)) continue;
      found.depth.all.add(of_depth, at);
      found.depth.tiles[tile].add(of_depth, at);
    }
  }
  return found;
}

void tell(const char* what, const Found& found) {
  WARN(what << ": " << found.all.events() << " events, best shift (" << found.all.best().u << ", "
            << found.all.best().v << ") px, across " << found.all.across_px() << " px, prominence "
            << found.all.prominence() << "; worst of " << found.clear_tiles() << " tiles "
            << found.worst_tile_px() << " px");
}

}  // namespace

TEST_CASE("events lie on the edges of the frames and of the depth, without any shift") {
  struct Case {
    Family family;
    int frames;
  };
  // Both move: the town's car from the start, the desk's arm after half of the frames.
  const Case shown = GENERATE(Case{Family::kTown1, 8}, Case{Family::kDesk, 30});
  const TemporaryFolder at;
  RecordingOptions options;
  options.family = shown.family;
  options.frames = shown.frames;
  options.seed = 1;
  options.clean_sensor = true;  // a slow photoreceptor lags by milliseconds, which move an edge, too
  write_recording(options, at / "recording");
  const recording::Folder folder = recording::open_folder(at / "recording");
  INFO(name_of(shown.family));
  REQUIRE(folder.truth.size() == static_cast<std::size_t>(shown.frames));
  REQUIRE(folder.camera.config.camera.distortion == Distortion::kPlumbBob);
  WARN(name_of(shown.family) << ": k1 " << folder.camera.config.camera.coefficients[0]);

  const Both right = correlate(folder, undistorted);
  tell("frame", right.frame);
  tell("depth", right.depth);
  CHECK(right.frame.all.events() > 3000);
  CHECK(right.depth.all.events() > 1000);
  CHECK(std::abs(right.frame.all.best().u) < 0.25);
  CHECK(std::abs(right.frame.all.best().v) < 0.25);
  CHECK(right.depth.all.across_px() < 0.25);
  CHECK(right.frame.worst_tile_px() < 0.5);
  CHECK(right.depth.worst_tile_px() < 0.5);
  CHECK(right.frame.clear_tiles() >= 6);

  // What is wrong on purpose is seen: no undistortion, and a grid that lies half a pixel beside.
  const Both bent = correlate(folder, as_it_is);
  tell("frame, distortion ignored", bent.frame);
  CHECK(bent.frame.worst_tile_px() > 0.75);
  CHECK(bent.frame.worst_tile_px() > 2 * right.frame.worst_tile_px());
  const Both beside =
      correlate(folder, [](const CameraModel& camera, const Intrinsics& grid, const Event& event) {
        const GridPlace place = undistorted(camera, grid, event);
        return GridPlace{place.u + 0.5, place.v - 0.5};
      });
  tell("frame, half a pixel beside", beside.frame);
  CHECK(beside.frame.all.best().u < -0.25);
  CHECK(beside.frame.all.best().v > 0.25);
}
