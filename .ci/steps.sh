# The steps of ./check: a table, and one function each. Sourced for the table; run as `steps.sh STEP` to do one step.
# A step's output is its log. A line that begins with "note: " is shown to the user even when the step passes.

# name | package groups | limit in seconds | starts after | what it does. The order is the order of start.
STEPS=(
  "format|format|60||every C and C++ file is as clang-format leaves it"
  "rules|test|60||include rule, file lengths, wording; each check is seen to fail on a planted violation"
  "dev|build convert test|900||g++, debug: build, all tests (in the whole run, asan does this and more)"
  "asan|build convert test|1200||address and undefined-behaviour sanitizers: build, all tests"
  "release|build convert test|900||g++, release: build, all tests, symbol bans"
  "aarch64|build test aarch64 qemu|1200||64-bit ARM cross build; tests on cortex-a53, cortex-a76, max"
  "armv7|build test armv7 qemu|1200||32-bit ARM cross build; tests on cortex-a9"
  "tsan|build convert test|900||thread sanitizer: build, tests with threads"
  "clang|build convert test clang|900||clang++, release: build, all tests, symbol bans"
  "headers|build convert test clang|600|release|each header compiles alone, with g++ and clang++"
  "nehalem|build test qemu|600|release|kernel tests on an emulated x86 without AVX"
  "checked|build test|900||every kernel call of the golden replays beside its scalar meaning"
  "install|build test install|600|release|a consumer of the installed library: static and shared, CMake and pkg-config"
  "install-aarch64|build test install aarch64 qemu|600|aarch64|the same against the 64-bit ARM tree, run emulated"
  "fuzz|build convert test clang|400||every fuzzer, 60 s in all"
  "training|build convert test training|600|release|what training needs: build, its tests"
  "readme|build test|120|release|the C++ example of the README compiles and links"
  "hil|build test aarch64 hil|2700|release|tests on real kernels in emulated amd64 and arm64 guests"
  "golden|test|30|asan release clang aarch64 armv7|the golden replay was run, and equal, in every build"
)
QUICK_STEPS=(format rules dev)
ONLY_QUICK=dev

# --- what the steps share ---------------------------------------------------------------------------------------------

fail() {
  echo "error: $*"
  exit 1
}

cpp_files() { # every C and C++ file of ours
  find include src apps tests bench tools training -type f \( -name '*.hpp' -o -name '*.cpp' -o -name '*.h' -o -name '*.c' \) 2>/dev/null |
    sort
}

# configure_and_build PRESET [cmake option ...]; TARGETS: these alone.
configure_and_build() {
  local preset=$1
  shift
  # shellcheck disable=SC2086
  cmake --preset "$preset" "$@" && cmake --build "build/$preset" -j "$JOBS" ${TARGETS:+--target $TARGETS} || exit 1
}

# run_ctest PRESET [ctest option ...]: no test may hang; a build without tests is a failure.
run_ctest() {
  local preset=$1
  shift
  ctest --test-dir "build/$preset" --no-tests=error --output-on-failure --timeout "${TEST_LIMIT:-300}" "$@"
}

# emulated PRESET QEMU_CPU [ctest option ...]: one run of the tests on an emulated processor, with a log for `golden`.
emulated() {
  local preset=$1 cpu=$2
  shift 2
  echo "=== $preset on $cpu"
  QEMU_CPU=$cpu TEST_LIMIT=600 run_ctest "$preset" --output-junit "tests-$cpu.xml" "$@"
}

# --- the steps --------------------------------------------------------------------------------------------------------

step_format() {
  local tool=clang-format
  command -v clang-format-14 >/dev/null && tool=clang-format-14
  local off
  off=$(cpp_files | xargs -r "$tool" --dry-run -Werror 2>&1) && return 0
  echo "$off"
  echo "error: these files are laid out differently. To mend: $tool -i" \
    $(sed -nE 's/^([^ :]+):[0-9]+:[0-9]+: error:.*/\1/p' <<<"$off" | sort -u)
  local major
  major=$("$tool" --version | grep -oE 'version [0-9]+' | grep -oE '[0-9]+')
  if [[ $major != 14 ]]; then
    # Another version lays out a few constructs differently; only version 14 decides.
    echo "note: clang-format $major would lay out some files differently; version 14 decides, so this is not a failure"
    return 0
  fi
  return 1
}

step_rules() {
  local failed=0 check
  for check in include_rule file_length wording; do
    python3 "tests/checks/$check.py" . || failed=1
  done
  bash tests/checks/can_fail.sh || failed=1
  return $failed
}

step_dev() {
  configure_and_build dev
  run_ctest dev --output-junit tests.xml -LE slow -j "$JOBS"
}

step_release() {
  configure_and_build release
  run_ctest release --output-junit tests.xml
}

step_clang() {
  configure_and_build clang
  run_ctest clang --output-junit tests.xml
}

step_asan() {
  configure_and_build asan
  ASAN_OPTIONS=detect_leaks=1:strict_string_checks=1 UBSAN_OPTIONS=print_stacktrace=1 \
    TEST_LIMIT=600 run_ctest asan --output-junit tests.xml -LE 'native|slow'
}

step_tsan() {
  TARGETS="test_core test_pipeline" configure_and_build tsan -DEGOFOCUS_BUILD_APPS=OFF
  TSAN_OPTIONS=halt_on_error=1 TEST_LIMIT=600 run_ctest tsan -LE 'native|slow' -R '^test_(core|pipeline)$'
}

step_aarch64() {
  configure_and_build aarch64
  # Everything once; what depends on the processor's instruction sets on the others as well.
  local cpu failed=0
  emulated aarch64 max -LE 'native|slow' || failed=1
  for cpu in cortex-a53 cortex-a76; do emulated aarch64 "$cpu" -LE 'native|slow' -R 'kernels|golden' || failed=1; done
  return $failed
}

step_armv7() {
  configure_and_build armv7
  emulated armv7 cortex-a9 -LE 'native|slow'
}

step_nehalem() {
  [[ $(uname -m) == x86_64 ]] || { echo "note: not an x86-64 machine: not run here"; return 0; }
  local tests test cpu
  mapfile -t tests < <(find build/release/tests/kernels -maxdepth 1 -type f -name 'test_*' -perm -u+x)
  ((${#tests[@]} > 0)) || fail "no kernel tests in build/release: run ./check --only release first"
  for test in "${tests[@]}"; do
    for cpu in Nehalem max; do
      echo "=== $test on $cpu"
      qemu-x86_64 -cpu "$cpu" "$test" || return 1
    done
  done
}

step_checked() {
  TARGETS="egofocus_app test_checked_kernels" configure_and_build checked
  run_ctest checked -R '^(golden_.*|test_checked_kernels)$'
}

step_headers() {
  [[ -d build/release/generated ]] || fail "build/release is missing: run ./check --only release first"
  bash tests/checks/headers_alone.sh . build/release/generated g++ "$JOBS" &&
    bash tests/checks/headers_alone.sh . build/release/generated clang++ "$JOBS"
}

step_install() {
  bash tests/checks/install_consumer.sh native static && bash tests/checks/install_consumer.sh native shared
}

step_install-aarch64() {
  bash tests/checks/install_consumer.sh aarch64 static && bash tests/checks/install_consumer.sh aarch64 shared
}

step_fuzz() {
  configure_and_build fuzz
  bash tests/checks/run_fuzzers.sh build/fuzz 60 2
}

step_training() {
  TARGETS="egofocus_stack egofocus_app test_window_stack test_network" configure_and_build training
  run_ctest training -L training
}

step_readme() {
  bash tests/checks/readme_example.sh . build/release
}

# A limit for the guests of its own, so that the build's time does not count; EGOFOCUS_HIL_PATIENCE=N makes it and those
# of each test N times as long, for a machine that others use.
step_hil() {
  python3 tests/hil/run.py --prepare || exit 1
  TARGETS="hil_programs" configure_and_build release && TARGETS="hil_programs" configure_and_build aarch64-hil
  local patience=${EGOFOCUS_HIL_PATIENCE:-4}
  timeout -k 10 $((600 * patience)) python3 tests/hil/run.py --patience "$patience"
}

step_golden() {
  python3 tests/checks/golden_everywhere.py build
}

if [[ ${BASH_SOURCE[0]} == "$0" ]]; then
  set -u
  cd "$(dirname "$0")/.." || exit 1
  JOBS=$(nproc)
  export PATH="/usr/bin:$PATH" # the system's python3 and compilers, whatever else stands first
  # A clone in another folder finds the objects of the last one.
  export CCACHE_BASEDIR=$PWD CCACHE_NOHASHDIR=1 CCACHE_SLOPPINESS=pch_defines,time_macros
  command -v ccache >/dev/null && export CMAKE_C_COMPILER_LAUNCHER=ccache CMAKE_CXX_COMPILER_LAUNCHER=ccache
  export CLICOLOR_FORCE=0 GTEST_COLOR=no NINJA_STATUS='[%f/%t] ' LC_ALL=C
  "step_$1"
fi
