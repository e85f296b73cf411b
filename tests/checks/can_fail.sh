#!/usr/bin/env bash
# A check that cannot fail checks nothing: plants one violation at a time in an empty tree and expects red.
# usage: can_fail.sh      exit code 1 when a check stays green
set -u
checks=$(cd "$(dirname "$0")" && pwd)
tree=$(mktemp -d)
trap 'rm -rf "$tree"' EXIT
bad=0
python=$(python3 -c "import sys; print(sys.executable)") # the interpreter itself: a version manager's wrapper is slow

fresh() { # an innocent tree
  rm -rf "${tree:?}"/*
  mkdir -p "$tree"/{include/egofocus,src/{core,hal,kernels,pipeline}}
  echo '#include <cstdint>' >"$tree/include/egofocus/types.hpp"
}
expect() { # expect green|red WHAT COMMAND...
  local wanted=$1 what=$2 got=green
  shift 2
  "$@" >"$tree/said" 2>&1 || got=red
  [[ $got == "$wanted" ]] && return 0
  echo "error: $what: expected $wanted, got $got"
  cat "$tree/said"
  bad=1
}
plant() { # plant CHECK FILE TEXT: CHECK is green without the text and red with it
  fresh
  expect green "$1 on an innocent tree" "$python" "$checks/$1.py" "$tree"
  mkdir -p "$(dirname "$tree/$2")"
  printf "$3" >"$tree/$2"
  expect red "$1 with '$3' in $2" "$python" "$checks/$1.py" "$tree"
}

plant include_rule src/core/a.cpp '#include "hal/b.hpp"\n'
plant include_rule src/hal/a.cpp '#include "kernels/b.hpp"\n'
plant include_rule src/kernels/a.inc '  #  include "hal/b.hpp"\n'
plant include_rule src/kernels/a.cpp '#include "pipeline/b.hpp"\n'
plant include_rule src/pipeline/a.cpp '#include "hal/evt3_decoder.hpp"\n'
plant include_rule src/pipeline/a.cpp '#include <Eigen/Core>\n'
plant include_rule src/core/a.cpp '#include <vector>\n'
plant include_rule src/core/a.cpp '#include <egofocus/types.hpp>\n'
plant include_rule include/egofocus/a.hpp '#include "core/ring.hpp"\n'
plant include_rule src/misc/a.hpp '\n'
plant file_length src/core/a.cpp "$(printf '\\n%.0s' {1..401})"
plant wording docs/a.md "a TO""DO\n"
plant wording src/core/a.hpp "// see /wo""rk/main/a\n"

if command -v cc >/dev/null; then
  symbols() { # symbols NAME SOURCE: the check on a library of this one object
    rm -f "$tree/lib.a"
    printf '%s\n' "$2" >"$tree/source.c"
    cc -O1 -c "$tree/source.c" -o "$tree/$1.c.o" && ar rc "$tree/lib.a" "$tree/$1.c.o"
    "$python" "$checks/symbols.py" nm "$checks/symbols_allowed.txt" "$tree/lib.a"
  }
  fresh
  expect green "symbols on an innocent object" symbols a 'int egofocus_a(int x) { return x; }'
  for banned in malloc free printf puts abort sin strtod pthread_mutex_lock pthread_cond_wait pthread_create \
    __cxa_throw _Znwm _ZdlPv _Unwind_Resume __assert_fail; do
    expect red "symbols: call of $banned" symbols a "void $banned(void); void egofocus_a(void) { $banned(); $banned(); }"
  done
  expect red "symbols: a lock in rt_thread" symbols rt_thread 'void pthread_mutex_lock(void); void egofocus_a(void) { pthread_mutex_lock(); }'
  expect green "symbols: set-up in rt_thread" symbols rt_thread 'void pthread_create(void); void egofocus_a(void) { pthread_create(); }'
  expect red "symbols: a foreign name" symbols a 'int helper(int x) { return x; }'
  expect red "symbols: Eigen" symbols a 'int _ZN5Eigen8egofocusEv(void) { return 1; }'
  weak='__attribute__((weak)) int egofocus_a(void) { return 1; }'
  expect green "symbols: weak in a plain object" symbols warp "$weak"
  expect red "symbols: weak in an AVX2 object" symbols warp_avx2 "$weak"
  shared() { # shared SOURCE: the check of exports; the public header declares egofocus_open alone
    echo 'int egofocus_open(void);' >"$tree/include/egofocus/types.hpp"
    printf '%s\n' "$1" >"$tree/source.c"
    cc -shared -fPIC "$tree/source.c" -o "$tree/lib.so"
    "$python" "$checks/symbols.py" nm --shared "$tree/include" "$tree/lib.so"
  }
  expect green "exports: the public API" shared 'int egofocus_open(void) { return 1; }'
  expect red "exports: an inner name" shared 'int egofocus_open(void) { return 1; } int egofocus_inner(void) { return 1; }'
  expect red "exports: nothing" shared 'static int a(void) { return 1; } int (*hidden)(void) __attribute__((visibility("hidden"))) = a;'
  fresh
  printf 'std::int32_t x;\n' >"$tree/src/core/a.hpp"
  expect red "headers_alone: a missing include" bash "$checks/headers_alone.sh" "$tree" "$tree" c++
  printf '#include <cstdint>\nextern std::int32_t x;\n' >"$tree/src/core/a.hpp"
  expect green "headers_alone" bash "$checks/headers_alone.sh" "$tree" "$tree" c++
fi

((bad == 0)) && echo "every planted violation was found"
exit $bad
