// A user's program: it sees only what was installed. Ends with "consumer: ok", or says what is wrong.
#include <cstdio>
#include <cstdlib>
#include <span>

#include "egofocus/engine.hpp"
#include "egofocus/version.hpp"

namespace {

int wrong(const egofocus::Status& status) {
  char line[200];
  status.describe(line);
  std::puts(line);
  return 1;
}

}  // namespace

int main() {
  egofocus::Config config;
  config.camera.intrinsics = {346, 260, 300.0, 300.0, 172.5, 129.5};
  std::size_t bytes = 0;
  if (const egofocus::Status status = egofocus::Engine::required_arena(config, bytes); !status.ok())
    return wrong(status);
  auto* memory = static_cast<std::byte*>(std::aligned_alloc(64, (bytes + 63) / 64 * 64));
  {
    egofocus::Engine engine;
    if (const egofocus::Status status = engine.configure(config, {memory, bytes}); !status.ok())
      return wrong(status);
    if (const egofocus::Status status = engine.start(egofocus::ClockKind::kVirtual, 50'000); !status.ok()) {
      return wrong(status);
    }
    egofocus::DepthFrame frame;
    if (!engine.tick() || !engine.newest(frame)) return std::puts("no frame came"), 1;
    if (frame.flags == 0) return std::puts("a frame without any sample has no flag"), 1;
    std::printf("egofocus %s, %zu bytes, %s\n", EGOFOCUS_VERSION, bytes, engine.isa());
  }
  std::free(memory);
  std::puts("consumer: ok");
  return 0;
}
