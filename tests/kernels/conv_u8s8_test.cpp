#include "kernels/conv_u8s8.hpp"

#include <catch2/catch.hpp>
#include <cstring>
#include <random>

#include "conv_case.hpp"
#include "exercised_isas.hpp"

using namespace egofocus;
using namespace egofocus::test;

namespace {

struct Row {
  const char* name;
  Isa isa;
  ConvU8S8Function* run;
  ConvPacking packing;
};

constexpr Row kRows[] = {
#define EGOFOCUS_CONV_U8S8(suffix, isa, tile_outputs, group_inputs) \
  {#suffix, Isa::isa, &conv_u8s8_##suffix, kConvPacking_##suffix},
#include "kernels/conv_u8s8.inc"
#undef EGOFOCUS_CONV_U8S8
};

constexpr ConvEpilogue kEveryEpilogue[] = {ConvEpilogue::kRelu, ConvEpilogue::kAdd, ConvEpilogue::kSmall,
                                           ConvEpilogue::kScore};

/// Around each tile that a body may have: outputs, pixels, groups of inputs; each epilogue; each window.
std::vector<ConvCaseShape> shapes() {
  std::vector<ConvCaseShape> all;
  const auto epilogue = [&all] { return kEveryEpilogue[all.size() % 4]; };
  for (std::int32_t o :
       {1, 2, 3, 4, 5, 7, 8, 9, 12, 15, 16, 17, 24, 31, 32, 33, 48, 63, 64, 65, 80, 81, 96, 128, 131})
    all.push_back({8, o, 3, 1, 1, 9, 2, epilogue()});
  for (std::int32_t i = 4; i <= 68; i += 4) {
    all.push_back({i, 17, 1, 1, 1, 5, 2, epilogue()});
    all.push_back({i, 8, 3, 1, 1, 11, 1, epilogue(), 0, i % 3});
  }
  for (std::int32_t columns :
       {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 15, 16, 17, 23, 24, 25, 31, 32, 33, 35, 49, 67}) {
    for (std::int32_t o : {1, 4, 8, 16, 48}) all.push_back({8, o, 3, 1, 1, columns, 1, epilogue()});
    for (std::int32_t i : {4, 16}) all.push_back({i, 4, 1, 1, 1, columns, 2, epilogue()});
    for (std::int32_t i : {4, 8}) {
      for (std::int32_t o : {1, 2}) all.push_back({i, o, 1, 1, 1, columns, 2, ConvEpilogue::kScore});
    }
  }
  for (ConvEpilogue each : kEveryEpilogue) {
    for (std::int32_t o : {1, 4, 8, 20, 35, 48, 80, 128}) {
      for (std::int32_t side : {1, 3}) {
        for (std::int32_t stride : {1, 2}) {
          all.push_back({8, o, side, stride, 1, 13, 2, each, 0, 0, 3, 5, 9});
          all.push_back({20, o, side, stride, 1, 10, 1, each, 3, 1, 0, 0, 1});
        }
      }
      for (std::int32_t dilation : {2, 4}) all.push_back({16, o, 3, 1, dilation, 19, 3, each, 1});
      all.push_back({4, o, 3, 1, 1, 35, 0, each, 2});
    }
  }
  for (std::int32_t o : {1, 4, 8, 16, 48, 80}) {
    all.push_back({8, o, 3, 1, 1, 37, 3, ConvEpilogue::kAdd, 1, 0, 0, 0, 2, true});
    all.push_back({48, o, 3, 1, 1, 11, 2, ConvEpilogue::kAdd, 0, 0, 16, 7, 0, true});
  }
  for (std::int32_t o : {1, 4, 8, 16, 48, 131}) {
    for (std::int32_t rows : {1, 2, 5}) {
      for (std::int32_t dilation : {1, 2, 4}) {
        all.push_back({16, o, 3, 1, dilation, 18, rows, epilogue(), 0, 0, 0, 0, 0, false, true});
        all.push_back({8, o, 3, 2, dilation, 9, rows, epilogue(), 1, 0, 0, 0, 3, false, true});
      }
    }
    all.push_back({16, o, 1, 1, 1, 18, 3, epilogue(), 0, 0, 0, 0, 0, false, true});
  }
  // Few outputs: what a body may do differently then, around the widths of its registers.
  for (std::int32_t o : {1, 4, 8}) {
    for (std::int32_t i : {4, 8, 16, 32, 48}) {
      for (ConvEpilogue each : {ConvEpilogue::kRelu, ConvEpilogue::kSmall, ConvEpilogue::kScore}) {
        for (std::int32_t columns : {7, 8, 9, 15, 16, 17, 24, 33, 40, 65})
          all.push_back({i, o, 3, 1, 1 + columns % 2, columns, 2, each, 0, 0, columns % 3 == 0 ? 16 : 0,
                         columns % 4 == 0 ? 3 : 0, columns % 5});
        all.push_back({i, o, 1, 1, 1, 70, 1, each, 1});
      }
    }
  }
  // Three planes; and eight dense inputs, which a body may read as whole rows.
  for (std::int32_t side : {1, 3}) {
    for (std::int32_t i : {4, 8, 16, 20}) {
      for (std::int32_t o : {1, 4, 7, 8, 12, 16, 48}) {
        all.push_back({i, o, side, 1, 1, 11, 2, epilogue(), 0, 0, 0, 0, 0, false, o % 8 == 0, 3, 5});
        all.push_back({i, o, side, 2, 1, 6, 1, epilogue(), 1, 1, i % 8, 3, 2, false, false, 3});
      }
    }
  }
  for (std::int32_t depth : {1, 3}) {
    for (std::int32_t columns : {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 13, 17, 18, 19, 27, 44}) {
      for (std::int32_t o : {4, 8, 12, 16}) {
        all.push_back({8, o, 3, 1, 1, columns, 2, epilogue(), 0, 0, 0, 0, 0, false, columns % 2 == 0, depth});
      }
    }
  }
  all.push_back({4, 1, 1, 1, 1, 33, 2, ConvEpilogue::kScore, 0, 0, 0, 0, 0, false, false, 3});
  all.push_back({144, 48, 1, 1, 1, 21, 2, ConvEpilogue::kRelu, 0, 5});
  all.push_back({4, 4, 3, 1, 1, 33, 2, ConvEpilogue::kRelu, 0, 0, 0, 140});  // into another tensor's channels
  all.push_back({4, 1, 1, 1, 1, 33, 2, ConvEpilogue::kScore, 0, 0, 140, 31});
  return all;
}

void compare(ConvCase& test_case, const Row& row) {
  const std::vector<std::uint8_t> expected = test_case.run(&conv_u8s8_scalar, kConvPacking_scalar);
  // Not REQUIRE(a == b): a failure would print whole tensors.
  const bool same_bytes = test_case.run(row.run, row.packing) == expected;
  REQUIRE(same_bytes);
}

}  // namespace

TEST_CASE("conv_u8s8: the scalar meaning agrees with scattered sums of 64 bits and products in binary64") {
  std::uint32_t seed = test_seed();
  for (const ConvCaseShape& shape : shapes()) {
    for (ConvFill fill : kEveryConvFill) {
      INFO(describe(shape) << " fill " << static_cast<int>(fill) << " seed " << ++seed);
      ConvCase test_case(shape, fill, seed);
      const bool same_bytes = test_case.run(&conv_u8s8_scalar, kConvPacking_scalar) == test_case.expect();
      REQUIRE(same_bytes);
    }
  }
}

TEST_CASE("conv_u8s8: every row that this processor runs has the bytes of the scalar one") {
  for (const Row& row : kRows) {
    if (!exercise("conv_u8s8", row.isa)) continue;
    std::uint32_t seed = test_seed();
    for (const ConvCaseShape& shape : shapes()) {
      for (ConvFill fill : kEveryConvFill) {
        INFO(row.name << " " << describe(shape) << " fill " << static_cast<int>(fill) << " seed " << ++seed);
        ConvCase test_case(shape, fill, seed);
        compare(test_case, row);
      }
    }
  }
}

TEST_CASE("conv_u8s8: random shapes") {
  for (const Row& row : kRows) {
    if (!exercise("conv_u8s8", row.isa)) continue;
    std::mt19937 random(test_seed());
    const auto below = [&random](std::uint32_t end) { return static_cast<std::int32_t>(random() % end); };
    for (int round = 0; round < 200; ++round) {
      ConvCaseShape shape{4 + 4 * below(24), 1 + below(100)};
      shape.side = 1 + 2 * below(2);
      shape.stride = 1 + below(2);
      shape.dilation = 1 + below(4);
      shape.columns = below(40);
      shape.rows = below(4);
      shape.epilogue = kEveryEpilogue[below(4)];
      shape.first_row = below(3);
      shape.missing_channels = below(4);
      shape.input_gap = below(2) * below(20);
      shape.output_gap = below(2) * below(20);
      shape.row_gap = below(20);
      shape.zeros_beyond = below(2) == 1;
      shape.depth = 1 + 2 * below(2);
      shape.plane_gap = below(2) * below(100);
      shape.in_place = shape.epilogue == ConvEpilogue::kAdd && below(2) == 1;
      const std::uint32_t seed = static_cast<std::uint32_t>(random());
      INFO(row.name << " round " << round << " " << describe(shape) << " seed " << seed);
      ConvCase test_case(shape, ConvFill::kRandom, seed);
      compare(test_case, row);
    }
  }
}

TEST_CASE("conv_u8s8: packed weights stand where the contract says, zeros elsewhere") {
  constexpr std::int8_t kWeights[] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};  // [3][1][1][5]
  constexpr std::int32_t kBias[] = {100, 200, 300};
  constexpr float kScale[] = {0.5f, 0.25f, 0.125f};
  const ConvWeights layer{kWeights, kBias, kScale, 5, 8, 3, 1, 1};
  const ConvPacking packing{2, 4};
  alignas(kConvPackedAlignment) std::byte memory[192];
  REQUIRE(conv_packed_bytes(packing, layer) == 192);
  const PackedConv packed = pack_conv_u8s8(packing, layer, memory);
  const std::vector<int> expected = {1,  2,  3,  4,  6, 7, 8, 9, 5,  0, 0, 0, 10, 0, 0, 0,
                                     11, 12, 13, 14, 0, 0, 0, 0, 15, 0, 0, 0, 0,  0, 0, 0};
  REQUIRE(std::vector<int>(packed.weights, packed.weights + 32) == expected);
  REQUIRE(std::vector<std::int32_t>(packed.bias, packed.bias + 4) ==
          std::vector<std::int32_t>{100, 200, 300, 0});
  REQUIRE(std::vector<float>(packed.scale, packed.scale + 4) ==
          std::vector<float>{0.5f, 0.25f, 0.125f, 0.0f});
}

TEST_CASE("conv_u8s8: copies of a layer are a layer with zeros off its diagonal") {
  constexpr std::int8_t kWeights[] = {1, 2, 3, 4, 5, 6};  // [2][1][1][3]
  constexpr std::int32_t kBias[] = {100, 200};
  constexpr float kScale[] = {0.5f, 0.25f};
  const ConvWeights two{.weights = kWeights,
                        .bias = kBias,
                        .scale = kScale,
                        .source_channels = 3,
                        .in_channels = 8,
                        .out_channels = 2,
                        .copies = 2};
  constexpr std::int8_t kWhole[] = {1, 2, 3, 0, 0, 0, 0, 0, 4, 5, 6, 0, 0, 0, 0, 0,
                                    0, 0, 0, 0, 1, 2, 3, 0, 0, 0, 0, 0, 4, 5, 6, 0};
  constexpr std::int32_t kBiases[] = {100, 200, 100, 200};
  constexpr float kScales[] = {0.5f, 0.25f, 0.5f, 0.25f};
  const ConvWeights whole{.weights = kWhole,
                          .bias = kBiases,
                          .scale = kScales,
                          .source_channels = 8,
                          .in_channels = 8,
                          .out_channels = 4};
  for (const ConvPacking& packing :
       {ConvPacking{1, 1}, ConvPacking{2, 4}, ConvPacking{16, 4}, ConvPacking{4, 16}}) {
    INFO(packing.tile_outputs << " x " << packing.group_inputs);
    alignas(kConvPackedAlignment) std::byte memory[2][512] = {};
    const auto bytes = static_cast<std::size_t>(conv_packed_bytes(packing, two));
    REQUIRE(bytes <= sizeof memory[0]);
    REQUIRE(conv_packed_bytes(packing, whole) == static_cast<std::int64_t>(bytes));
    pack_conv_u8s8(packing, two, memory[0]);
    pack_conv_u8s8(packing, whole, memory[1]);
    REQUIRE(std::memcmp(memory[0], memory[1], bytes) == 0);
  }
}
