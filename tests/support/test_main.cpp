#define CATCH_CONFIG_MAIN
#define CATCH_CONFIG_NO_POSIX_SIGNALS  // MINSIGSTKSZ is no constant in recent glibc
#include <catch2/catch.hpp>
