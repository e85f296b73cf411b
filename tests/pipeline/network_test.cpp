// The network against training's integer model: 0 differing bytes, in every tensor, for any number of threads
// and every instruction set of this machine. EGOFOCUS_NETWORK_VECTORS names another folder of vectors.
#include "pipeline/network.hpp"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <memory>

#include "kernels/isa.hpp"
#include "pipeline/half_counts.hpp"
#include "support/arena_block.hpp"
#include "support/network_vectors.hpp"
#include "support/source_dir.hpp"

using namespace egofocus;
using test::VectorArray;
using test::VectorCase;

namespace {

// One whose hypotheses have channels of their own, and one where two share what a convolution reads.
std::vector<std::string> vectors_folders() {
  const char* other = std::getenv("EGOFOCUS_NETWORK_VECTORS");
  if (other != nullptr) return {other};
  return {test::source_dir() + "/fixtures/network", test::source_dir() + "/fixtures/network_pairs"};
}

// A network with its own memory, and whatever else a tick would have around it.
struct Bench {
  Bench(const Model& model, const Intrinsics& grid, int threads, IsaSet allowed) {
    const KernelTable kernels = select_kernels(detect_isa() & allowed);
    Arena counter;
    {
      MemoryPlan plan;
      const Network::Buffers buffers(model.facts, grid, threads, plan);
      plan.place(counter);
      const Network counted(model, grid, kernels, threads, buffers, plan, counter);
    }
    block = std::make_unique<test::ArenaBlock>(counter.used_bytes());
    Arena arena(block->span());
    MemoryPlan plan;
    const Network::Buffers buffers(model.facts, grid, threads, plan);
    plan.place(arena);
    network = std::make_unique<Network>(model, grid, kernels, threads, buffers, plan, arena);
    REQUIRE(arena.used_bytes() == counter.used_bytes());
    REQUIRE(pool.start(threads, 0, -1).ok());
  }
  std::unique_ptr<test::ArenaBlock> block;
  std::unique_ptr<Network> network;
  WorkerPool pool;
};

std::vector<std::uint8_t> packed(const VectorArray& half) {
  const std::size_t cells = half.shape[1] * half.shape[2];
  std::vector<std::uint8_t> out(half.shape[0] * half_counts_bytes(cells));
  for (std::size_t k = 0; k < half.shape[0]; ++k)
    pack_half_counts(std::span(half.bytes).subspan(k * cells, cells), &out[k * half_counts_bytes(cells)]);
  return out;
}

struct Comparison {
  const VectorCase& expected;
  std::size_t compared = 0;
  std::size_t differing = 0;

  // expected: [channels][height][width], or [height][width] of values of several bytes.
  void bytes(const std::string& name, const Tensor& tensor) {
    const auto found = expected.find(name == "mixed" ? "cost" : name);
    if (found == expected.end()) return;
    const VectorArray& array = found->second;
    const bool flat = array.shape.size() == 2;
    const std::size_t height = array.shape[flat ? 0 : 1];
    const std::size_t width = array.shape[flat ? 1 : 2];
    REQUIRE(static_cast<std::size_t>(tensor.shape.height) == height);
    REQUIRE(static_cast<std::size_t>(tensor.shape.width) == width);
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < array.bytes.size(); ++i) {
      const std::size_t value = i / array.type;
      const std::size_t c = flat ? i % array.type : value / (width * height);
      const std::size_t pixel = value % (width * height);
      const std::uint8_t* row = tensor.row(static_cast<std::int32_t>(pixel / width));
      wrong += row[pixel % width * static_cast<std::size_t>(tensor.shape.channels) + c] != array.bytes[i];
    }
    INFO("tensor " << name);
    CHECK(wrong == 0);
    differing += wrong;
    ++compared;
  }
};

void compare(Bench& bench, const VectorCase& expected, std::size_t tensors) {
  Comparison comparison{expected};
  bench.network->watch({&comparison, [](void* self, const char* name, const Tensor& tensor) {
                          static_cast<Comparison*>(self)->bytes(name, tensor);
                        }});
  const std::uint32_t used = expected.at("used").at(0);
  INFO("hypotheses used: " << used);
  const std::vector<std::uint8_t> half = packed(expected.at("half"));
  const CellDepth out = bench.network->run(
      {expected.at("focus").bytes, expected.at("context").bytes, half, static_cast<std::int32_t>(used)},
      bench.pool);
  CHECK(comparison.compared >= tensors);
  const VectorArray& index = expected.at("index");
  const VectorArray& trust = expected.at("confidence");
  REQUIRE(out.index_q8.size() == index.size());
  REQUIRE_FALSE(out.median);
  std::size_t wrong = 0;
  std::size_t untrusted = 0;
  for (std::size_t i = 0; i < index.size(); ++i) {
    const std::size_t y = i / index.shape[1];
    const std::size_t x = i % index.shape[1];
    const std::uint32_t c = trust.at(y / 2 * trust.shape[1] + x / 2);
    wrong += out.index_q8[i] != index.at(i);
    untrusted += out.confidence[i] != (c > 0 ? c : 1);
  }
  CHECK(wrong == 0);
  CHECK(untrusted == 0);
}

Intrinsics grid_of(const VectorCase& expected) {
  // Which of two sizes a half-size map belongs to does not show in it: the odd one, where nothing lies
  // beyond.
  const VectorArray& half = expected.at("half");
  Intrinsics grid;
  grid.width_px = static_cast<std::int32_t>(2 * half.shape[2]) - 1;
  grid.height_px = static_cast<std::int32_t>(2 * half.shape[1]) - 1;
  return grid;
}

}  // namespace

TEST_CASE("the network's bytes are the integer model's") {
  const std::string folder = GENERATE(from_range(vectors_folders()));
  INFO(folder);
  const test::ModelMemory file(test::file_bytes(folder + "/model.efm"));
  const auto model = std::make_unique<Model>();
  REQUIRE(read_model(file.bytes(), *model).ok());
  const std::vector<VectorCase> cases = test::read_cases(folder + "/cases.bin");
  REQUIRE(cases.size() >= 3);
  const Intrinsics grid = grid_of(cases[0]);
  const bool other_vectors = std::getenv("EGOFOCUS_NETWORK_VECTORS") != nullptr;

  SECTION("every tensor of every case, one thread, the machine's best kernels") {
    Bench bench(*model, grid, 1, ~IsaSet{0});
    for (const VectorCase& expected : cases) {
      // What an earlier window left behind changes nothing.
      compare(bench, expected, expected.count("a4") > 0 ? 9 : 2);
    }
  }
  SECTION("any number of threads") {
    for (const int threads : {2, 3, 8}) {
      INFO("threads " << threads);
      Bench bench(*model, grid, threads, ~IsaSet{0});
      for (std::size_t i = 0; i < cases.size() && i < 5; ++i) compare(bench, cases[i], 2);
    }
  }
  SECTION("every instruction set") {
    for (const Isa isa : kEveryIsa) {
      if (!has_isa(detect_isa(), isa)) continue;
      INFO("instruction set " << isa_name(isa));
      Bench bench(*model, grid, 1, isa_bit(isa));
      for (std::size_t i = 0; i < cases.size() && (i < 3 || !other_vectors); ++i) compare(bench, cases[i], 2);
    }
  }
}

TEST_CASE("the vectors are worth comparing") {
  if (std::getenv("EGOFOCUS_NETWORK_VECTORS") != nullptr) return;
  const std::vector<VectorCase> cases =
      test::read_cases(GENERATE(from_range(vectors_folders())) + "/cases.bin");
  bool one = false, all = false, some = false, empty = false, saturated = false;
  std::size_t free_pixels = 0, pixels = 0;
  for (const VectorCase& c : cases) {
    const std::uint32_t used = c.at("used").at(0);
    one |= used == 1;
    all |= used == 16;
    some |= used > 1 && used < 16;
    empty |= c.at("focus").bytes[0] == 0 && c.at("half").bytes[0] == 0;
    saturated |= c.at("half").bytes[0] == 255;
    const VectorArray& index = c.at("index");
    for (std::size_t i = 0; used > 1 && i < index.size(); ++i, ++pixels)
      free_pixels += index.at(i) > 0 && index.at(i) < 256 * (used - 1);
  }
  CHECK((one && all && some && empty && saturated));
  CHECK(free_pixels > pixels / 2);
}
