// A caller's bug: caught in debug builds, a documented precondition in release ones.
#pragma once

#ifndef NDEBUG
#define EGOFOCUS_CHECK(condition) ((condition) ? static_cast<void>(0) : __builtin_trap())
#else
#define EGOFOCUS_CHECK(condition) static_cast<void>(0)
#endif
