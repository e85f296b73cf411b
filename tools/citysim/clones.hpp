// Loops that are worth compiling once for each vector width; the loader picks. The numbers are the same.
#pragma once

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && defined(__OPTIMIZE__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define CITYSIM_CLONES __attribute__((target_clones("arch=skylake-avx512", "avx2", "default")))
#else
#define CITYSIM_CLONES
#endif
