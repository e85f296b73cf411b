#!/usr/bin/env bash
# Installs the library into an empty prefix, moves the prefix, and builds and runs a consumer of it with CMake and with
# pkg-config. For a foreign target the consumer runs under qemu.
# usage: install_consumer.sh native|aarch64 static|shared
set -u
target=$1 kind=$2
root=$(cd "$(dirname "$0")/../.." && pwd)
work="$root/build/consumer/$target-$kind"
rm -rf "$work"
mkdir -p "$work"

step() { # step WHAT COMMAND...: silent when it works
  local what=$1
  shift
  "$@" >"$work/step.log" 2>&1 && return 0
  cat "$work/step.log"
  echo "error: $target $kind: $what failed"
  exit 1
}

toolchain=() runner=() compiler=c++ c_compiler=cc nm=nm shared=OFF
if [[ $target == aarch64 ]]; then
  toolchain=("-DCMAKE_TOOLCHAIN_FILE=$root/toolchains/aarch64-linux-gnu.cmake")
  emulator=$(command -v qemu-aarch64 || command -v qemu-aarch64-static) || { echo "error: no qemu-aarch64"; exit 1; }
  runner=("$emulator" -L /usr/aarch64-linux-gnu)
  compiler=aarch64-linux-gnu-g++
  c_compiler=aarch64-linux-gnu-gcc
  nm=aarch64-linux-gnu-nm
fi
[[ $kind == shared ]] && shared=ON

tree=$root/build/release # the static library is what ./check builds anyway
[[ $target == aarch64 ]] && tree=$root/build/aarch64
if [[ $kind == shared || ! -f $tree/libegofocus.a ]]; then
  tree=$work/library
  step "configuring the library" cmake -G Ninja -S "$root" -B "$tree" "${toolchain[@]}" -DCMAKE_BUILD_TYPE=Release \
    -DBUILD_SHARED_LIBS=$shared -DEGOFOCUS_BUILD_APPS=OFF -DEGOFOCUS_BUILD_TESTS=OFF
  step "building the library" cmake --build "$tree"
fi
step "installing" cmake --install "$tree" --prefix "$work/first"
mv "$work/first" "$work/prefix" # nothing may depend on the place
libdir=$(dirname "$(find "$work/prefix" -name 'libegofocus.*' | head -n 1)")
if leaks=$(grep -rlIF -e "$root" -e "$work/first" "$work/prefix"); then
  echo "error: these installed files name the place where they were built: $leaks"
  exit 1
fi

step "find_package" cmake -G Ninja -S "$root/tests/checks/consumer" -B "$work/by-cmake" "${toolchain[@]}" \
  -DCMAKE_BUILD_TYPE=Release -Degofocus_DIR="$libdir/cmake/egofocus"
step "building with CMake" cmake --build "$work/by-cmake"
if cmake -G Ninja -S "$root/tests/checks/consumer" -B "$work/by-cmake-wrong" "${toolchain[@]}" \
     -DEGOFOCUS_WISH=9.0 -Degofocus_DIR="$libdir/cmake/egofocus" >"$work/step.log" 2>&1; then
  echo "error: $target $kind: the package answers a wish for version 9.0"
  exit 1
fi

export PKG_CONFIG_LIBDIR="$libdir/pkgconfig"
static_flag=()
[[ $kind == static ]] && static_flag=(--static)
read -ra flags < <(pkg-config "${static_flag[@]}" --cflags --libs egofocus) || { echo "error: pkg-config failed"; exit 1; }
step "building with pkg-config" "$compiler" -std=c++20 "$root/tests/checks/consumer/main.cpp" -o "$work/by-pkg-config" \
  "${flags[@]}"
# A C program needs no C++ run-time: the library uses none.
step "building C with pkg-config" "$c_compiler" -std=c11 "$root/tests/checks/c_api_test.c" -o "$work/c-by-pkg-config" \
  "${flags[@]}"
# The example in C, by its own Makefile.
cp -r "$root/examples/feed_engine" "$work/example"
step "building examples/feed_engine" make -C "$work/example" CC="$c_compiler" PKG_CONFIG="pkg-config ${static_flag[*]}" \
  CFLAGS="-O2 -Wall -Wextra -Werror"

run() { # run PROGRAM
  # The loader of an emulated program reads the variable too; qemu hands it on by -E.
  if ((${#runner[@]} > 0)); then
    timeout 60 "${runner[@]}" -E "LD_LIBRARY_PATH=$libdir" "$1" 2>&1
  else
    LD_LIBRARY_PATH=$libdir timeout 60 "$1" 2>&1
  fi
}
for program in "$work/by-cmake/consumer" "$work/by-pkg-config" "$work/c-by-pkg-config"; do
  said=$(run "$program")
  [[ $said == *": ok" ]] || { echo "$said"; echo "error: $target $kind: ${program#"$root"/} does not run"; exit 1; }
done
said=$(run "$work/example/feed_engine")
[[ $said =~ flags\ 0,\ median\ depth\ (1\.9|2\.0)[0-9]\ m.running,\ 0\ events\ dropped$ ]] ||
  { echo "$said"; echo "error: $target $kind: examples/feed_engine does not see the wall at 2 m"; exit 1; }

if [[ $kind == shared ]]; then
  python3 "$root/tests/checks/symbols.py" "$nm" --shared "$work/prefix/include" "$libdir/libegofocus.so" || exit 1
fi
echo "$target $kind: installed, moved, consumed by CMake, pkg-config and C, examples/feed_engine as well"
