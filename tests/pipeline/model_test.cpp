// Model files: what a sound one says, and how each way of being wrong is told.
#include "pipeline/model.hpp"

#include <catch2/catch.hpp>
#include <cstring>
#include <memory>
#include <string>

#include "pipeline/model_bytes.hpp"
#include "support/network_vectors.hpp"
#include "support/source_dir.hpp"

using namespace egofocus;

namespace {

std::string sound_file() {
  return test::file_bytes(test::source_dir() + "/fixtures/network/model.efm");
}

void put_u32(std::string& file, std::size_t at, std::uint32_t value) {
  for (std::size_t i = 0; i < 4; ++i) file[at + i] = static_cast<char>(value >> (8 * i));
}

std::uint32_t u32(const std::string& file, std::size_t at) {
  return read_u32(std::as_bytes(std::span(file)), at);
}

// The check sum agrees again: what is wrong must be found by looking.
Status read_resealed(std::string file) {
  put_u32(file, 16, crc32(std::as_bytes(std::span(file)).subspan(20)));
  const test::ModelMemory memory(file);
  const auto model = std::make_unique<Model>();
  return read_model(memory.bytes(), *model);
}

Status read_as_it_is(const std::string& file) {
  const test::ModelMemory memory(file);
  const auto model = std::make_unique<Model>();
  return read_model(memory.bytes(), *model);
}

// Sections as the writer orders them: facts, card, layers, data.
std::size_t section(const std::string& file, std::size_t n) {
  return u32(file, 32 + 16 * n + 8);
}

}  // namespace

TEST_CASE("a check sum is the well-known one") {
  const std::string text = "123456789";
  CHECK(crc32(std::as_bytes(std::span(text))) == 0xcbf43926u);
}

TEST_CASE("a sound model says what it is") {
  const test::ModelMemory memory(sound_file());
  const auto model = std::make_unique<Model>();
  REQUIRE(read_model(memory.bytes(), *model).ok());
  const ModelFacts& facts = model->facts;
  CHECK(facts.ladder.hypotheses == 16);
  CHECK(facts.ladder.kind == LadderKind::kParallax);
  CHECK(facts.ladder.span_px == 40.0);
  CHECK(facts.max_events == 80000);
  CHECK(facts.input.map_count == 3);
  CHECK(facts.input.maps[1].kind == FocusMapKind::kSquares);
  CHECK(facts.input.maps[1].side == 7);
  CHECK(facts.input.maps[2].kind == FocusMapKind::kGradientX);
  CHECK(facts.dilation_count == 2);
  CHECK(facts.dilations[1] == 2);
  CHECK(model->layer_count == 2 + 1 + 2 * (1 + 1 + 2 + 1 + 1) + 2 + 2 + 4 + 2 + 1);
  CHECK(model->layer(LayerRole::kMix).shape == LayerShape{12, 16 * 4 + 9, 1, 1, 1, 0});
  CHECK(model->layer(LayerRole::kFocusCost).shape == LayerShape{8, 3, 3, 1, 1, 64});
  CHECK(model->layer(LayerRole::kBody, 1).shape.dilation == 2);
  CHECK(model->card.starts_with("name: "));
}

TEST_CASE("an embedded model may be followed by other bytes") {
  CHECK(read_as_it_is(sound_file() + std::string(40, 'x')).ok());
}

TEST_CASE("whatever byte is damaged, it is seen") {
  const std::string file = sound_file();
  for (std::size_t at = 0; at < file.size(); at += at < 2000 ? 1 : 997) {
    std::string damaged = file;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x20);
    INFO("byte " << at);
    CHECK_FALSE(read_as_it_is(damaged).ok());
  }
  for (std::size_t size = 0; size < file.size(); size += size < 200 ? 1 : 4999)
    CHECK(read_as_it_is(file.substr(0, size)).code() == StatusCode::kBadModel);
}

TEST_CASE("each cause is told with its place") {
  const std::string file = sound_file();
  const std::size_t facts = section(file, 0);
  const std::size_t layers = section(file, 2);
  const auto changed = [&](std::size_t at, std::uint32_t value) {
    std::string other = file;
    put_u32(other, at, value);
    return read_resealed(other);
  };
  SECTION("version") {
    const Status status = changed(8, 2);
    CHECK(status.code() == StatusCode::kUnsupportedModel);
    CHECK(status.value() == 2);
    CHECK(status.bound() == Model::kVersion);
    char text[200];
    status.describe(text);
    CHECK(std::string(text).starts_with("unsupported model: version 2, known is 1."));
  }
  SECTION("operator") {
    CHECK(changed(layers, 7).code() == StatusCode::kUnsupportedModel);
  }
  SECTION("regression") {
    CHECK(changed(facts + 108, 0).code() == StatusCode::kUnsupportedModel);
  }
  SECTION("hypotheses") {
    const Status status = changed(facts + 20, 17);
    CHECK(status.code() == StatusCode::kBadModel);
    CHECK(std::string(status.subject()) == "hypotheses");
    CHECK(status.value() == static_cast<std::int64_t>(facts + 20));
    CHECK(status.bound() == 17);
  }
  SECTION("a span that is no number") {
    CHECK_FALSE(changed(facts + 4, 0x7ff80000u).ok());
  }
  SECTION("channels per hypothesis") {
    for (const std::uint32_t channels : {0u, 1u, 3u, 5u, 18u, 0xfffffffeu}) {
      INFO(channels);
      CHECK(std::string(changed(facts + 68, channels).subject()) == "channels per hypothesis");
    }
    CHECK(std::string(changed(facts + 68, 2).subject()) == "layer of another shape than the facts say");
  }
  SECTION("widths that are none") {
    CHECK_FALSE(changed(facts + 72, 0xfffffffcu).ok());
  }
  SECTION("more blocks than layers") {
    CHECK(std::string(changed(facts + 84, 3).subject()) == "number of layers");
  }
  SECTION("a layer of another shape") {
    const Status status = changed(layers + 4, 9);
    CHECK(status.value() == static_cast<std::int64_t>(layers + 4));
    CHECK(status.bound() == 9);
  }
  SECTION("weights beyond the end") {
    for (const std::uint32_t offset : {0xfffffff0u, static_cast<std::uint32_t>(file.size()) - 16, 0u, 33u}) {
      for (const std::size_t field : {7u, 8u, 9u}) {
        INFO("offset " << offset << " field " << field);
        if (field != 7 && offset == static_cast<std::uint32_t>(file.size()) - 16) continue;  // it fits there
        CHECK(changed(layers + 4 * field, offset).code() == StatusCode::kBadModel);
      }
    }
  }
  SECTION("a section beyond the end, missing, twice") {
    CHECK_FALSE(changed(32 + 16 * 3 + 12, 0xfffffff0u).ok());
    CHECK_FALSE(changed(32 + 16 * 3 + 8, 0xfffffff0u).ok());
    CHECK_FALSE(changed(32, 99).ok());
    CHECK_FALSE(changed(32, 2).ok());
    CHECK_FALSE(changed(20, 0xffffffffu).ok());
  }
  SECTION("scales that requantisation has no words for") {
    const std::size_t scale = u32(file, layers + 36);
    for (const float value : {0.0f, 1.0f, -0.5f, 0x1p-41f, std::numeric_limits<float>::quiet_NaN(),
                              std::numeric_limits<float>::infinity()}) {
      std::uint32_t bits = 0;
      std::memcpy(&bits, &value, 4);
      const Status status = changed(scale + 4, bits);
      CHECK(status.code() == StatusCode::kBadModel);
      CHECK(status.value() == static_cast<std::int64_t>(scale + 4));
    }
  }
  SECTION("weights and biases that could overflow") {
    std::string other = file;
    other[u32(file, layers + 28)] = '\x80';
    CHECK(std::string(read_resealed(other).subject()) == "weight -128");
    CHECK(std::string(changed(u32(file, layers + 32), 0x40000001u).subject()) == "bias beyond 2^30");
    CHECK(changed(u32(file, layers + 32), 0x40000000u).ok());
  }
  SECTION("a card with control characters") {
    std::string other = file;
    other[section(file, 1)] = '\x1b';
    CHECK_FALSE(read_resealed(other).ok());
  }
  SECTION("what is no model at all") {
    CHECK(std::string(read_as_it_is(std::string(100, 'x')).subject()) == "no model file");
    CHECK_FALSE(read_as_it_is("").ok());
  }
}
