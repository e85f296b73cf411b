# What the commands need, and how it is installed. Sourced by ./check and ./demo.
#
# A row of a group is `package probe[,probe]`: a program on the PATH, or a file (globs allowed) when it holds a slash.
# One probe that is there is enough, so that other distributions and hand-made installations pass as well.
# The package names are Debian 12's.

packages_of() {
  case "$1" in
    build) cat <<'ROWS'
g++ c++,g++
cmake cmake
ninja-build ninja
libeigen3-dev /usr/include/eigen3/Eigen/Core,/usr/local/include/eigen3/Eigen/Core
libtomlplusplus-dev /usr/include/toml++/toml.h,/usr/local/include/toml++/toml.h
libcli11-dev /usr/include/CLI/CLI.hpp,/usr/local/include/CLI/CLI.hpp
libpng-dev /usr/include/png.h,/usr/local/include/png.h
libusb-1.0-0-dev /usr/include/libusb-1.0/libusb.h,/usr/local/include/libusb-1.0/libusb.h
ROWS
      ;;
    test) cat <<'ROWS'
catch2 /usr/include/catch2/catch.hpp,/usr/local/include/catch2/catch.hpp
ccache ccache
python3 python3
python3-numpy /usr/lib/python3/dist-packages/numpy/__init__.py
make make
pkg-config pkg-config
ROWS
      ;;
    convert) cat <<'ROWS'
libhdf5-dev /usr/include/hdf5/serial/hdf5.h,/usr/include/hdf5.h,/usr/local/include/hdf5.h
libyaml-cpp-dev /usr/include/yaml-cpp/yaml.h,/usr/local/include/yaml-cpp/yaml.h
liblz4-dev /usr/include/lz4frame.h,/usr/local/include/lz4frame.h
libzstd-dev /usr/include/zstd.h,/usr/local/include/zstd.h
hdf5-filter-plugin-blosc-serial /usr/lib/*/hdf5/serial/plugins/libH5Zblosc.so,/usr/local/hdf5/lib/plugin/libH5Zblosc.so
ROWS
      ;;
    format) echo "clang-format clang-format,clang-format-14" ;;
    clang) cat <<'ROWS'
clang clang++
libclang-rt-dev /usr/lib/llvm-*/lib/clang/*/lib/linux/libclang_rt.fuzzer-*.a,/usr/lib/clang/*/lib/linux/libclang_rt.fuzzer-*.a
ROWS
      ;;
    qemu) echo "qemu-user qemu-aarch64,qemu-aarch64-static" ;;
    aarch64) echo "g++-aarch64-linux-gnu aarch64-linux-gnu-g++" ;;
    armv7) echo "g++-arm-linux-gnueabihf arm-linux-gnueabihf-g++" ;;
    count) cat <<'ROWS'
clang-19 clang++-19,clang++
llvm-19 llvm-mca-19,llvm-mca
ROWS
      ;;
    install) echo "pkg-config pkg-config" ;;
    hil) cat <<'ROWS'
qemu-system-x86 qemu-system-x86_64
qemu-system-arm qemu-system-aarch64
binutils readelf
apt apt-get
ROWS
      ;;
    bench) cat <<'ROWS'
libbenchmark-dev /usr/include/benchmark/benchmark.h,/usr/local/include/benchmark/benchmark.h
libdnnl-dev /usr/include/dnnl.hpp,/usr/local/include/dnnl.hpp
ROWS
      ;;
    training) cat <<'ROWS'
pybind11-dev /usr/include/pybind11/pybind11.h,/usr/local/include/pybind11/pybind11.h
python3-dev /usr/include/python3*/Python.h
python3-torch /usr/lib/python3/dist-packages/torch/__init__.py
python3-pil /usr/lib/python3/dist-packages/PIL/__init__.py
python3-onnx /usr/lib/python3/dist-packages/onnx/__init__.py
python3-pytest /usr/lib/python3/dist-packages/pytest/__init__.py
ROWS
      ;;
  esac
}

probe_found() {
  local probe
  local IFS=,
  for probe in $1; do
    if [[ $probe == */* ]]; then
      compgen -G "$probe" >/dev/null && return 0
    else
      command -v "$probe" >/dev/null && return 0
    fi
  done
  return 1
}

# The packages of the groups whose probes find nothing, one a line.
missing_packages() {
  local group package probes
  for group in "$@"; do
    while read -r package probes; do
      [[ -n $package ]] && ! probe_found "$probes" && echo "$package"
    done < <(packages_of "$group")
  done | sort -u
}

# require_packages LOG GROUP...: installs what is missing; exits with 3 when that is not possible.
require_packages() {
  local log=$1
  shift
  local missing
  mapfile -t missing < <(missing_packages "$@")
  ((${#missing[@]} == 0)) && return 0
  local line="apt-get update && apt-get install -y --no-install-recommends ${missing[*]}"
  if ! command -v apt-get >/dev/null; then
    echo "Not found on this machine (names as in Debian 12): ${missing[*]}"
    echo "Install their counterparts here, then run this command again."
    exit 3
  fi
  if ((EUID != 0)); then
    echo "Some packages are missing. Run this line once, then this command again:"
    echo "  sudo sh -c '$line'"
    exit 3
  fi
  echo "installing ${#missing[@]} packages: ${missing[*]}"
  if ! (export DEBIAN_FRONTEND=noninteractive
        apt-get update && apt-get install -y --no-install-recommends "${missing[@]}") >"$log" 2>&1 </dev/null; then
    tail -n 15 "$log"
    echo "apt-get failed; the whole log is $log. Run this line by hand to see why:"
    echo "  $line"
    exit 3
  fi
}
