// Which instruction sets the kernel tests really ran. At the end of the run they are printed, and the program
// fails when one that was compiled in and that this processor has (or that EGOFOCUS_EXPECT_ISA names, as in
// "sse41,avx2") was not among them: a vector body that silently went missing would otherwise pass every test.
#pragma once

#include <cstdint>

#include "kernels/isa.hpp"

namespace egofocus::test {

/// True when this processor can run the row; the row then counts as exercised.
bool exercise(const char* op, Isa isa);

/// Seed of all random fills: EGOFOCUS_TEST_SEED, or a fixed one. Printed at the end of the run.
std::uint32_t test_seed();

}  // namespace egofocus::test
