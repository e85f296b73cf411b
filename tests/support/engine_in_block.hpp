// An engine with its own memory, for tests.
#pragma once

#include <memory>

#include "egofocus/engine.hpp"
#include "support/arena_block.hpp"

namespace egofocus::test {

class EngineInBlock {
 public:
  explicit EngineInBlock(const Config& config) {
    std::size_t bytes = 0;
    status = Engine::required_arena(config, bytes);
    if (!status.ok()) return;
    block_ = std::make_unique<ArenaBlock>(bytes);
    status = engine_.configure(config, block_->span());
  }
  Engine* operator->() noexcept { return &engine_; }
  Engine& operator*() noexcept { return engine_; }

  Status status;

 private:
  std::unique_ptr<ArenaBlock> block_;  // outlives the engine
  Engine engine_;
};

}  // namespace egofocus::test
