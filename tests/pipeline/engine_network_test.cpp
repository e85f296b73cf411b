// The engine with the network backend: what it needs, what it refuses, and that its frames depend on nothing
// but the samples. The model is the fixture's, of random weights: depth means nothing here.
#include <catch2/catch.hpp>
#include <cstring>
#include <string>

#include "pipeline/model.hpp"
#include "pipeline/model_bytes.hpp"
#include "support/engine_in_block.hpp"
#include "support/frame_hash.hpp"
#include "support/network_vectors.hpp"
#include "support/sliding_scene.hpp"
#include "support/source_dir.hpp"

using namespace egofocus;
using test::EngineInBlock;
using test::SlidingScene;

namespace {

std::string model_file() {
  return test::file_bytes(test::source_dir() + "/fixtures/network/model.efm");
}

Config config_with(const test::ModelMemory& model) {
  Config config = SlidingScene::config();
  config.backend = Backend::kNetwork;
  config.model = model.bytes();
  return config;
}

// The check sum agrees again.
void reseal(std::string& file) {
  const std::uint32_t crc = crc32(std::as_bytes(std::span(file)).subspan(20));
  for (std::size_t i = 0; i < 4; ++i) file[16 + i] = static_cast<char>(crc >> (8 * i));
}

Status refusal(const Config& config) {
  std::size_t bytes = 1;
  const Status status = Engine::required_arena(config, bytes);
  CHECK(bytes == 0);
  alignas(64) static std::byte block[64];
  Engine engine;
  CHECK(engine.configure(config, block).code() == status.code());
  CHECK(engine.start(ClockKind::kVirtual, 0).code() == StatusCode::kBadState);  // nothing is half-started
  return status;
}

struct Run {
  test::FrameHash hash;
  std::uint64_t with_depth = 0;
  std::int32_t hypotheses = 0;
};

Run run(Config config) {
  EngineInBlock engine(config);
  REQUIRE(engine.status.ok());
  REQUIRE(engine->start(ClockKind::kVirtual, 50'000).ok());
  SlidingScene scene;
  Run out;
  for (int i = 0; i < 8; ++i) {
    const std::int64_t from_us = i * 50'000;
    engine->inlets().push(scene.events(from_us, from_us + 50'000));
    engine->inlets().push(SlidingScene::poses(from_us, from_us + 50'000));
    REQUIRE(engine->tick());
    DepthFrame frame;
    REQUIRE(engine->newest(frame));
    out.hash.add(frame);
    if (frame.hypotheses == 0) continue;
    ++out.with_depth;
    out.hypotheses = frame.hypotheses;
    for (const std::uint8_t c : frame.confidence) REQUIRE(c >= 1);
    // What earlier ticks knew may be nearer than this one's ladder.
    const std::int32_t most = config.carry.fuse_us > 0 ? 65535 : 256 * (frame.hypotheses - 1);
    for (const std::uint16_t v : frame.inverse_depth) REQUIRE(v <= most);
  }
  return out;
}

}  // namespace

TEST_CASE("the model's ladder is used, and neither threads nor instruction sets change a byte") {
  const test::ModelMemory model(model_file());
  Config config = config_with(model);
  config.motion.source = MotionSource::kPoses;
  config.rate.rate_hz = 20;
  config.ladder.hypotheses = 64;  // the model has 16
  config.window.max_events = 500;
  const Run one = run(config);
  CHECK(one.with_depth >= 5);
  CHECK(one.hypotheses <= 16);
  for (const int threads : {2, 3}) {
    config.threads = threads;
    CHECK(run(config).hash.value() == one.hash.value());
  }
  config.threads = 1;
  config.isa_mask = 0;
  CHECK(run(config).hash.value() == one.hash.value());
}

TEST_CASE("depth is fused over ticks where that is asked for, and threads change no byte of it either") {
  const test::ModelMemory model(model_file());
  Config config = config_with(model);
  config.motion.source = MotionSource::kPoses;
  config.rate.rate_hz = 20;
  config.window.max_events = 500;
  const Run alone = run(config);
  config.carry.fuse_us = 500'000;
  const Run fused = run(config);
  CHECK(fused.with_depth == alone.with_depth);
  CHECK(fused.hash.value() != alone.hash.value());
  config.threads = 3;
  CHECK(run(config).hash.value() == fused.hash.value());
  config.carry.fuse_us = 1;  // nothing lasts to the next tick
  CHECK(run(config).hash.value() == alone.hash.value());
}

TEST_CASE("a damaged or misplaced model is refused with its cause") {
  const test::ModelMemory sound(model_file());
  Config config = config_with(sound);
  config.model = sound.bytes().first(1000);
  CHECK(std::string(refusal(config).subject()) == "cut short");
  const test::ModelMemory shifted("x" + model_file());
  config.model = shifted.bytes().subspan(1);
  CHECK(std::string(refusal(config).subject()) == "its memory does not begin at a multiple of 16");
  std::string file = model_file();
  file[3000] = static_cast<char>(file[3000] ^ 1);
  const test::ModelMemory damaged(file);
  CHECK(std::string(refusal(config_with(damaged)).subject()) == "damaged (check sum)");
}

TEST_CASE("a model of another version, or with an unknown operator, is refused with both numbers") {
  const auto refused = [](std::size_t at, char value) {
    std::string file = model_file();
    file[at] = value;
    reseal(file);
    const test::ModelMemory model(file);
    return refusal(config_with(model));
  };
  const Status version = refused(8, 9);
  CHECK(version.code() == StatusCode::kUnsupportedModel);
  CHECK(version.value() == 9);
  CHECK(version.bound() == Model::kVersion);
  const std::string file = model_file();
  const Status op = refused(read_u32(std::as_bytes(std::span(file)), 32 + 2 * 16 + 8), 77);
  CHECK(std::string(op.subject()) == "operator");
  CHECK(op.value() == 77);
}

TEST_CASE("a ladder that cannot be is refused, though the model's would take its place") {
  const test::ModelMemory model(model_file());
  Config config = config_with(model);
  config.ladder.hypotheses = 65;
  const Status status = refusal(config);
  CHECK(status.code() == StatusCode::kBadLadder);
  CHECK(status.value() == 65);
  config = config_with(model);
  config.window.max_events = 0;
  CHECK(refusal(config).code() == StatusCode::kBadWindow);
}

TEST_CASE("a model for another grid is refused with both sizes") {
  std::string file = model_file();
  const std::size_t facts = read_u32(std::as_bytes(std::span(file)), 32 + 8);
  const auto put = [&](std::size_t at, std::uint32_t value) {
    for (std::size_t i = 0; i < 4; ++i) file[at + i] = static_cast<char>(value >> (8 * i));
  };
  const Intrinsics camera = SlidingScene::config().camera.intrinsics;
  put(facts + 56, static_cast<std::uint32_t>(camera.width_px));
  put(facts + 60, static_cast<std::uint32_t>(camera.height_px) + 4);
  reseal(file);
  const test::ModelMemory model(file);
  const Status status = refusal(config_with(model));
  CHECK(status.code() == StatusCode::kModelMismatch);
  CHECK(std::string(status.subject()) == "grid height");
  CHECK(status.value() == camera.height_px);
  CHECK(status.bound() == camera.height_px + 4);
}

TEST_CASE("an arena one byte too small names the bytes") {
  const test::ModelMemory model(model_file());
  const Config config = config_with(model);
  std::size_t bytes = 0;
  REQUIRE(Engine::required_arena(config, bytes).ok());
  const test::ArenaBlock block(bytes);
  Engine engine;
  const Status small = engine.configure(config, block.span().first(bytes - 1));
  CHECK(small.code() == StatusCode::kArenaTooSmall);
  CHECK(small.bound() == static_cast<std::int64_t>(bytes));
  CHECK(engine.configure(config, block.span()).ok());
}
