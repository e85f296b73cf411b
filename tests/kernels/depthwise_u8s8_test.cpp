#include "kernels/depthwise_u8s8.hpp"

#include <catch2/catch.hpp>
#include <random>

#include "depthwise_case.hpp"
#include "exercised_isas.hpp"

using namespace egofocus;
using namespace egofocus::test;

namespace {

struct Row {
  const char* name;
  Isa isa;
  DepthwiseU8S8Function* run;
  DepthwisePacking packing;
};

constexpr Row kRows[] = {
#define EGOFOCUS_DEPTHWISE_U8S8(suffix, isa, block_channels, by_columns) \
  {#suffix, Isa::isa, &depthwise_u8s8_##suffix, kDepthwisePacking_##suffix},
#include "kernels/depthwise_u8s8.inc"
#undef EGOFOCUS_DEPTHWISE_U8S8
};

constexpr ConvEpilogue kEveryEpilogue[] = {ConvEpilogue::kRelu, ConvEpilogue::kAdd, ConvEpilogue::kSmall};

/// Around each register that a body may have, in channels and along a row; each epilogue; each window.
std::vector<DepthwiseCaseShape> shapes() {
  std::vector<DepthwiseCaseShape> all;
  const auto epilogue = [&all] { return kEveryEpilogue[all.size() % 3]; };
  for (std::int32_t c : {4, 8, 12, 16, 20, 24, 28, 32, 36, 48, 60, 64, 68, 80, 96, 100, 128, 132}) {
    for (std::int32_t columns : {1, 2, 3, 7}) {
      for (std::int32_t rows : {1, 2, 3}) all.push_back({c, columns, rows, epilogue()});
    }
    for (std::int32_t stride : {1, 2}) {
      all.push_back({c, 5, 2, epilogue(), stride, 1, 1, 3, 0, 5});
      all.push_back({c, 4, 3, epilogue(), stride, 1, 0, 0, 9});
      all.push_back({c, 6, 2, epilogue(), stride, 2});
    }
  }
  for (ConvEpilogue each : kEveryEpilogue) {
    for (std::int32_t columns :
         {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 15, 16, 17, 31, 32, 33, 35, 63, 64, 65, 131}) {
      for (std::int32_t c : {4, 8, 20}) all.push_back({c, columns, 2, each, 1, 1, columns % 3});
      all.push_back({12, columns, 1, each, 2});
    }
    for (std::int32_t dilation : {2, 3, 4}) all.push_back({40, 9, 3, each, 1 + dilation % 2, dilation});
    all.push_back({48, 3, 0, each});
  }
  for (std::int32_t c : {4, 16, 48, 100}) {
    all.push_back({c, 19, 3, ConvEpilogue::kAdd, 1, 1, 1, 0, 0, 7, true});
    all.push_back({c, 5, 2, ConvEpilogue::kAdd, 2, 1, 0, 0, 16, 0, true});
  }
  return all;
}

void compare(DepthwiseCase& test_case, const Row& row) {
  const std::vector<std::uint8_t> expected = test_case.run(&depthwise_u8s8_scalar, kDepthwisePacking_scalar);
  // Not REQUIRE(a == b): a failure would print whole tensors.
  const bool same_bytes = test_case.run(row.run, row.packing) == expected;
  REQUIRE(same_bytes);
}

}  // namespace

TEST_CASE(
    "depthwise_u8s8: the scalar meaning agrees with scattered sums of 64 bits and products in binary64") {
  std::uint32_t seed = test_seed();
  for (const DepthwiseCaseShape& shape : shapes()) {
    for (ConvFill fill : kEveryConvFill) {
      INFO(describe(shape) << " fill " << static_cast<int>(fill) << " seed " << ++seed);
      DepthwiseCase test_case(shape, fill, seed);
      const bool same_bytes =
          test_case.run(&depthwise_u8s8_scalar, kDepthwisePacking_scalar) == test_case.expect();
      REQUIRE(same_bytes);
    }
  }
}

TEST_CASE("depthwise_u8s8: every row that this processor runs has the bytes of the scalar one") {
  for (const Row& row : kRows) {
    if (!exercise("depthwise_u8s8", row.isa)) continue;
    std::uint32_t seed = test_seed();
    for (const DepthwiseCaseShape& shape : shapes()) {
      for (ConvFill fill : kEveryConvFill) {
        INFO(row.name << " " << describe(shape) << " fill " << static_cast<int>(fill) << " seed " << ++seed);
        DepthwiseCase test_case(shape, fill, seed);
        compare(test_case, row);
      }
    }
  }
}

TEST_CASE("depthwise_u8s8: random shapes") {
  for (const Row& row : kRows) {
    if (!exercise("depthwise_u8s8", row.isa)) continue;
    std::mt19937 random(test_seed());
    const auto below = [&random](std::uint32_t end) { return static_cast<std::int32_t>(random() % end); };
    for (int round = 0; round < 200; ++round) {
      DepthwiseCaseShape shape{4 + 4 * below(40)};
      shape.columns = below(40);
      shape.rows = below(5);
      shape.epilogue = kEveryEpilogue[below(3)];
      shape.stride = 1 + below(2);
      shape.dilation = 1 + below(2) * below(4);
      shape.first_row = below(3);
      shape.input_gap = below(2) * below(20);
      shape.output_gap = below(2) * below(20);
      shape.row_gap = below(20);
      shape.in_place = shape.epilogue == ConvEpilogue::kAdd && below(2) == 1;
      const std::uint32_t seed = static_cast<std::uint32_t>(random());
      INFO(row.name << " round " << round << " " << describe(shape) << " seed " << seed);
      DepthwiseCase test_case(shape, ConvFill::kRandom, seed);
      compare(test_case, row);
    }
  }
}

TEST_CASE("depthwise_u8s8: packed weights stand where the contract says") {
  std::vector<std::int8_t> weights;  // 12 channels: 10 c + tap
  std::vector<std::int32_t> bias;
  std::vector<float> scale;
  for (int c = 0; c < 12; ++c) {
    for (int tap = 0; tap < 9; ++tap) weights.push_back(static_cast<std::int8_t>(10 * c + tap));
    bias.push_back(1000 * c);
    scale.push_back(0.01f * static_cast<float>(c));
  }
  const DepthwiseWeights layer{weights.data(), bias.data(), scale.data(), 12};

  const DepthwisePacking by_rows{8, false};
  REQUIRE(depthwise_blocks(by_rows, 12) == 3);
  REQUIRE(depthwise_packed_bytes(by_rows, 12) == 256 + 128 + 128);
  const AlignedMemory rows_memory(512);
  const PackedConv rows = pack_depthwise_u8s8(by_rows, layer, rows_memory.data);
  REQUIRE(rows.weights[72 + 5 * 8 + 6] == 10 * 2 + 5);  // block 1, tap 5, position 6: channel (8 + 6) mod 12
  REQUIRE(rows.bias[8 + 6] == 2000);
  REQUIRE(rows.scale[8 + 6] == scale[2]);

  const DepthwisePacking by_columns{32, true};
  REQUIRE(depthwise_blocks(by_columns, 12) == 3);
  const AlignedMemory columns_memory(depthwise_packed_bytes(by_columns, 12));
  const PackedConv columns = pack_depthwise_u8s8(by_columns, layer, columns_memory.data);
  // Block 1, position 21 = 16 + 4 + 1: second four of the upper sixteen; channel (32 + 21) mod 12 = 5.
  const int at = 8 + 4 + 1;
  const std::int8_t* const upper = columns.weights + 768 + (2 * 32 + at) * 4;  // kx = 2
  REQUIRE(std::vector<int>(upper, upper + 4) == std::vector<int>{52, 55, 58, 0});
  const std::int8_t* const lower = upper + 3 * 32 * 4;
  REQUIRE(std::vector<int>(lower, lower + 4) == std::vector<int>{0, 52, 55, 58});
  REQUIRE(columns.bias[32 + at] == 5000);
  REQUIRE(columns.scale[32 + at] == scale[5]);
}
