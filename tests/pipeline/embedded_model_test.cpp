// The model inside the library, and what an engine takes that is asked for nothing else.
#include "pipeline/embedded_model.hpp"

#include <catch2/catch.hpp>
#include <cstring>
#include <memory>
#include <string>

#include "kernels/isa.hpp"
#include "pipeline/model.hpp"
#include "support/engine_in_block.hpp"
#include "support/network_vectors.hpp"
#include "support/source_dir.hpp"

using namespace egofocus;

namespace {

Config davis() {
  Config config;
  config.camera.intrinsics = {346, 260, 250, 250, 172.5, 129.5};
  return config;
}

ArenaBytes arena_of(const Config& config) {
  ArenaBytes bytes;
  REQUIRE(Engine::required_arena(config, bytes).ok());
  CHECK(bytes.all == bytes.engine + bytes.rings + bytes.window + bytes.motion + bytes.warp + bytes.backend +
                         bytes.weights + bytes.depth);
  return bytes;
}

}  // namespace

TEST_CASE("the network is the default backend where a model is embedded, and only there") {
  const bool embedded = !embedded_model().empty();
  CHECK(Config{}.backend == (embedded ? Backend::kNetwork : Backend::kFocus));
  Config config = davis();
  config.backend = Backend::kNetwork;
  std::size_t bytes = 0;
  const Status status = Engine::required_arena(config, bytes);
  if (embedded) {
    CHECK(status.ok());
  } else {
    CHECK(status.code() == StatusCode::kBadModel);
    CHECK(std::string(status.subject()).find("embeds none") != std::string::npos);
  }
}

#ifdef EGOFOCUS_TEST_EMBEDDED_MODEL
TEST_CASE("the embedded model is the file, where a loader wants it, and loads") {
  const std::string file = test::file_bytes(EGOFOCUS_TEST_EMBEDDED_MODEL);
  REQUIRE(embedded_model().size() == file.size());
  CHECK(std::memcmp(embedded_model().data(), file.data(), file.size()) == 0);
  CHECK(reinterpret_cast<std::uintptr_t>(embedded_model().data()) % Model::kAlignment == 0);
  const auto model = std::make_unique<Model>();
  CHECK(read_model(embedded_model(), *model).ok());
}
#endif

TEST_CASE("the arenas of the shipped models are what they are, within their bounds without the rings") {
  struct Shipped {
    const char* file;
    std::size_t most, window, backend, weights, depth, all, without_rings;
  };
  const Shipped shipped =
      GENERATE(Shipped{"base/base.efm", 8'200'000, 992768, 3375296, 1371456, 1079808, 9048832, 7779072},
               Shipped{"small/small.efm", 7'100'000, 992768, 3375296, 263040, 1079808, 7940416, 6670656});
  INFO(shipped.file);
  const test::ModelMemory model(test::file_bytes(test::source_dir() + "/models/" + shipped.file));
  Config config = davis();
  config.backend = Backend::kNetwork;
  config.model = model.bytes();
  for (const Isa isa : kEveryIsa) {
    config.isa_mask = isa_bit(isa);
    const ArenaBytes bytes = arena_of(config);
    INFO(isa_name(isa));
    CHECK(bytes.all - bytes.rings <= shipped.most);
  }
  config.isa_mask = 0;  // each body packs its weights otherwise, and all but the scalar vote wants scratch
  const ArenaBytes bytes = arena_of(config);
  CHECK(bytes.window == shipped.window);
  CHECK(bytes.backend == shipped.backend);
  CHECK(bytes.weights == shipped.weights);
  CHECK(bytes.depth == shipped.depth);
  if (sizeof(void*) == 8) {
    CHECK(bytes.all == shipped.all);
    CHECK(bytes.all - bytes.rings == shipped.without_rings);
  }
}

TEST_CASE("threads, poses and larger sensors take what they take") {
  const test::ModelMemory model(test::file_bytes(test::source_dir() + "/models/small/small.efm"));
  Config config = davis();
  config.backend = Backend::kNetwork;
  config.model = model.bytes();
  config.isa_mask = 0;
  const ArenaBytes plain = arena_of(config);
  SECTION("a thread its planes, rows and cells, and no lines of its own") {
    config.threads = 4;
    CHECK(arena_of(config).backend == 3996160);
    CHECK(arena_of(config).warp == plain.warp);
  }
  SECTION("poses a history of their own, in the place of the filter's") {
    config.motion.source = MotionSource::kPoses;
    CHECK(arena_of(config).all == plain.all);
  }
  SECTION("1280x720 seen through the same grid: more rays, and shorter slices of time") {
    config.grid = config.camera.intrinsics;
    config.camera.intrinsics = {1280, 720, 900, 900, 639.5, 359.5};
    const ArenaBytes wide = arena_of(config);
    CHECK(wide.warp == 8 * 1280 * 720);
    CHECK(wide.window == 4 * 80'000 * 3 + 65'536 * 4);
    CHECK(wide.backend == plain.backend);
  }
  SECTION("1280x720 as the grid itself") {
    config.camera.intrinsics = {1280, 720, 900, 900, 639.5, 359.5};
    const ArenaBytes large = arena_of(config);
    CHECK(large.backend == 26561472);
    config.threads = 4;
    CHECK(arena_of(config).backend == 34183168);
  }
}

TEST_CASE("an engine says which kernels it runs with which instruction sets") {
  const test::ModelMemory small(test::file_bytes(test::source_dir() + "/fixtures/network/model.efm"));
  Config config = davis();
  config.isa_mask = 0;
  config.backend = Backend::kFocus;
  test::EngineInBlock focus(config);
  REQUIRE(focus.status.ok());
  CHECK(std::string(focus->isa()) == "warp_vote scalar");
  config.backend = Backend::kNetwork;
  config.model = small.bytes();
  test::EngineInBlock network(config);
  REQUIRE(network.status.ok());
  CHECK(std::string(network->isa()) == "warp_vote scalar, conv_u8s8 scalar");
}
