// citysim-realism: the comparison as a program of its own.
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "citysim/realism.hpp"
#include "recording/error.hpp"

int main(int argc, char** argv) {
  using egofocus::recording::Error;
  using egofocus::recording::ExitCode;
  try {
    return egofocus::citysim::run_realism(std::vector<std::string>(argv + 1, argv + argc));
  } catch (const Error& error) {
    std::fprintf(stderr, "citysim-realism: %s\n", error.what());
    return error.exit_code();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "citysim-realism: internal error: %s\n", error.what());
    return static_cast<int>(ExitCode::kInternal);
  }
}
