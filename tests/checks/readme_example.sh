#!/usr/bin/env bash
# The first C++ block of the README compiles, warnings being errors, and links against the library.
# usage: readme_example.sh ROOT BUILD_DIR
set -u
root=$1 build=$2
example="$build/readme_example.cpp"
[[ -f $root/README.md ]] || { echo "note: there is no README.md yet"; exit 0; }
[[ -f $build/libegofocus.a ]] || { echo "error: $build/libegofocus.a is missing: run ./check --only release first"; exit 1; }
awk '/^```cpp/ && !done { inside = 1; next } /^```/ && inside { inside = 0; done = 1 } inside' "$root/README.md" >"$example"
[[ -s $example ]] || { echo "error: README.md has no C++ example (a block that begins with \`\`\`cpp)"; exit 1; }
if ! g++ -std=c++20 -Wall -Wextra -Werror -I"$root/include" -I"$build/generated" "$example" "$build/libegofocus.a" -pthread \
      -o "$build/readme_example"; then
  echo "error: the C++ example of README.md does not compile"
  exit 1
fi
echo "the README's example: $(grep -c . "$example") lines, compiled and linked"
