// A user's program: it sees only what was installed. Prints "consumer: ok", or what is wrong.
#include <cstdio>
#include <span>

#include "egofocus/engine.hpp"
#include "egofocus/version.hpp"

int main() {
  const egofocus::Status status(egofocus::StatusCode::kArenaTooSmall, "arena", 1, 2);
  char line[200];
  if (status.describe(std::span<char>(line)) == 0) return std::puts("describe() wrote nothing"), 1;
  std::printf("egofocus %s: %s\n", EGOFOCUS_VERSION, line);
  std::puts("consumer: ok");
  return 0;
}
