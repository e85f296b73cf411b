// The faults that scripted devices can make: one line of JSON per fault, then exit code 1 if any of them did
// what no fault may. tests/reliability/fault_matrix.py makes the table of them and of those that need a
// process.
// usage: scripted_faults [NAME ...]
#include <algorithm>
#include <cstdio>
#include <string_view>

#include "resident_memory.hpp"
#include "trial.hpp"

int main(int argc, char** argv) {
  using namespace egofocus::reliability;
  const auto is_wanted = [&](std::string_view name) {
    return argc == 1 || std::any_of(argv + 1, argv + argc, [&](const char* wish) { return name == wish; });
  };
  make_program_resident();
  int failures = 0;
  for (const auto& family : {camera_faults, load_faults, motion_faults}) {
    for (const Fault& fault : family()) {
      if (!is_wanted(fault.name)) continue;
      const Row row = fault.run();
      std::puts(row.json().json().c_str());
      std::fflush(stdout);
      failures += row.complaints.empty() ? 0 : 1;
    }
  }
  return failures == 0 ? 0 : 1;
}
