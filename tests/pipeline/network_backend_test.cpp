// The network backend, which keeps a few planes at a time, and sums where lines were, against its pieces one
// after the other with all lines, all planes and all sums kept.
#include "pipeline/network_backend.hpp"

#include <catch2/catch.hpp>
#include <memory>
#include <random>
#include <vector>

#include "pipeline/half_counts.hpp"
#include "support/arena_block.hpp"
#include "support/network_vectors.hpp"
#include "support/source_dir.hpp"

using namespace egofocus;

namespace {

constexpr std::int64_t kLength_us = 100'000;

struct Depth {
  std::vector<std::uint16_t> index_q8;
  std::vector<std::uint8_t> confidence;
  std::uint64_t votes = 0;
  std::uint64_t behind_camera = 0;
  friend bool operator==(const Depth&, const Depth&) = default;
};

Depth depth_of(const CellDepth& cells, const Warp& warp) {
  return {{cells.index_q8.begin(), cells.index_q8.end()},
          {cells.confidence.begin(), cells.confidence.end()},
          warp.votes(),
          warp.behind_camera()};
}

// A camera that slides and backs away over random events: near hypotheses of the oldest lie behind it.
class Scene {
 public:
  Scene(std::int32_t width, std::int32_t height, const Model& model, int events, int max_events)
      : model_(model) {
    config.camera.intrinsics = {width, height, 60, 60, 0.5 * width, 0.5 * height};
    config.ladder.hypotheses = model.facts.ladder.hypotheses;
    config.window.max_events = max_events;
    config.window.min_events = 0;
    std::mt19937 random(static_cast<unsigned>(events));
    for (int i = 0; i < events; ++i) {
      const auto below = [&](std::int32_t end) {
        return static_cast<std::uint16_t>(random() % static_cast<unsigned>(end));
      };
      events_.push_back({kLength_us * i / events, below(width), below(height), 1});
    }
    MotionSample motion;
    motion.velocity_m_s[0] = 1;
    motion.velocity_m_s[2] = -8;
    integrate_track({&motion, 1}, 0, kLength_us, track_);
    ladder_.step_per_m = 1.6 / config.ladder.hypotheses;
  }

  Depth by_backend(std::int32_t used, int threads) {
    config.threads = threads;
    test::RoomyArena arena(std::size_t{1} << 26);
    const EventWindow window = filled(*arena);
    const NetworkMemory memory(config, model_, *arena);
    Warp warp(config, kernels_, *arena, memory.lines());
    warp.prepare(config.camera);
    NetworkBackend backend(config, model_, kernels_, memory, *arena);
    WorkerPool pool;
    REQUIRE(pool.start(threads, 0, -1).ok());
    const EventWindow::Selection selection = window.select(0, kLength_us);
    ladder_.count = used;
    Depth out;
    for (int tick = 0; tick < 2; ++tick) {  // nothing of a tick is left in the next one
      for (int part = 0; part < threads; ++part)
        warp.project(window, selection, track_, ladder_, part, threads);
      backend.vote(warp, ladder_, track_.knots[0].centre_m, pool);
      backend.prepare_input(pool);
      out = depth_of(backend.run(pool), warp);
    }
    return out;
  }

  Depth by_pieces(std::int32_t used) {
    config.threads = 1;
    test::RoomyArena arena(std::size_t{1} << 27);
    const EventWindow window = filled(*arena);
    Warp warp(config, kernels_, *arena);
    warp.prepare(config.camera);
    ladder_.count = used;
    warp.project(window, window.select(0, kLength_us), track_, ladder_, 0, 1);
    warp.vote(0, 1);
    WorkerPool pool;
    REQUIRE(pool.start(1, 0, -1).ok());
    const Intrinsics grid = config.camera.intrinsics;
    FocusInput input(model_.facts.input, grid, config.ladder.hypotheses, 1, *arena);
    input.run(warp.planes(), ladder_, track_.knots[0].centre_m, pool);
    std::vector<std::uint8_t> half;
    for (std::int32_t k = 0; k < used; ++k) {
      std::vector<std::uint8_t> counts(cell_grid(grid).size());
      halve_counts(warp.plane(k), grid.width_px, grid.height_px, counts);
      half.resize(half.size() + half_counts_bytes(counts.size()));
      pack_half_counts(counts, half.data() + half.size() - half_counts_bytes(counts.size()));
    }
    MemoryPlan plan;
    const Network::Buffers buffers(model_.facts, grid, 1, plan);
    plan.place(*arena);
    Network network(model_, grid, kernels_, 1, buffers, plan, *arena);
    return depth_of(network.run({input.focus(), input.context(), half, used}, pool), warp);
  }

  Config config;

 private:
  EventWindow filled(Arena& arena) const {
    EventWindow window(config.window, config.camera.intrinsics, arena);
    for (const Event& event : events_) window.add(event);
    return window;
  }

  const Model& model_;
  KernelTable kernels_ = select_kernels(detect_isa());
  std::vector<Event> events_;
  MotionTrack track_;
  HypothesisLadder ladder_;
};

struct LoadedModel {
  explicit LoadedModel(const char* path)
      : file(test::file_bytes(test::source_dir() + path)), model(std::make_unique<Model>()) {
    REQUIRE(read_model(file.bytes(), *model).ok());
  }
  test::ModelMemory file;
  std::unique_ptr<Model> model;
};

}  // namespace

TEST_CASE("the backend's depth is that of all lines, planes and sums kept, for any number of threads") {
  const LoadedModel loaded("/fixtures/network/model.efm");
  const int events = GENERATE(3, 9000, 39'000, 100'000);  // the last: decimated
  const auto [width, height] = GENERATE(std::pair{72, 56}, std::pair{41, 23});
  const int max_events = GENERATE(40'000, 200);  // few lines: less than the sums that take their place
  Scene scene(width, height, *loaded.model, events, max_events);
  const std::int32_t all = loaded.model->facts.ladder.hypotheses;
  for (const std::int32_t used : {1, all / 2, all / 2 + 1, all}) {
    const Depth expected = scene.by_pieces(used);
    CHECK(expected.votes > 0);
    if (events > 3 && events <= max_events) CHECK((expected.behind_camera > 0) == (used == all));
    for (const int threads : {1, 2, 4}) {
      INFO(width << "x" << height << ", " << events << " events, " << used << " hypotheses, " << threads
                 << " threads");
      CHECK((scene.by_backend(used, threads) == expected));
    }
  }
}

TEST_CASE("the last sums find room in the stack's block, on any grid and for any ladder") {
  for (const std::int32_t width : {8, 9, 41, 346, 1280}) {
    for (const std::int32_t height : {8, 13, 260, 720}) {
      for (std::int32_t hypotheses = 1; hypotheses <= 64; ++hypotheses) {
        for (const std::int32_t max_events : {100, 20'000, 80'000, 1'000'000}) {
          const int threads = 1 + (hypotheses + width) % 8;
          const Intrinsics grid{width, height, 100, 100, 0, 0};
          const StackLayout stack(grid, hypotheses, max_events, threads);
          const std::size_t sums = FocusInput::sums_bytes(grid, 1);
          const auto plane = static_cast<std::size_t>(width * height);
          const auto at_once = static_cast<std::size_t>(stack.at_once);
          const auto placed = static_cast<std::size_t>(stack.placed);
          INFO(width << "x" << height << ", " << hypotheses << ", " << max_events << ", " << threads);
          REQUIRE(placed * sums <= stack.lines_at);  // while there are lines
          REQUIRE(stack.lines_at + Warp::lines_bytes(max_events) <= stack.planes_at);
          REQUIRE(stack.sums_bytes == static_cast<std::size_t>(hypotheses) * sums);
          REQUIRE(stack.sums_bytes <= stack.planes_at);  // while there are planes
          REQUIRE(stack.bytes >= stack.planes_at + at_once * plane);
          REQUIRE(stack.placed < hypotheses);
          REQUIRE(hypotheses - stack.placed <= stack.at_once);
          REQUIRE(stack.at_once >= std::min(hypotheses, threads));  // a plane for each
        }
      }
    }
  }
}
