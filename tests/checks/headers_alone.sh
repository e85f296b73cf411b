#!/usr/bin/env bash
# Every header compiles as the only line of a program; the C header also as C11.
# usage: headers_alone.sh ROOT GENERATED_INCLUDE_DIR COMPILER [JOBS]
set -u
root=$1 generated=$2 compiler=$3 jobs=${4:-1}

compile() {
  local header=$1
  local common=(-fsyntax-only -Wall -Wextra -Werror -I"$root/include" -I"$root/src" -I"$generated"
                -isystem /usr/include/eigen3 -isystem /usr/local/include/eigen3)
  local include="${header#"$root"/include/}"
  include="${include#"$root"/src/}"
  printf '#include "%s"\n' "$include" |
    "$compiler" -std=c++20 "${common[@]}" -x c++ - || { echo "error: $header does not compile alone ($compiler)"; return 1; }
  if [[ $header == *.h ]]; then
    printf '#include "%s"\n' "$include" | "$c_compiler" -std=c11 -pedantic "${common[@]}" -x c - 2>&1 ||
      { echo "error: $header is not C11"; return 1; }
  fi
}
export -f compile
export root generated
c_compiler=gcc; [[ $compiler == clang* ]] && c_compiler=clang
export compiler c_compiler
mapfile -t headers < <(find "$root/include" "$root/src" -name '*.hpp' -o -name '*.h' | sort)
((${#headers[@]} > 0)) || { echo "error: no headers found under $root"; exit 1; }
printf '%s\n' "${headers[@]}" | xargs -P "$jobs" -I{} bash -c 'compile {}' || exit 1
echo "${#headers[@]} headers compile alone with $compiler"
