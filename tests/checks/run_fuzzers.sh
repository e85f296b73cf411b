#!/usr/bin/env bash
# Runs every fuzzer of a build for an equal share of the time. A finding is written beside the log and named.
# usage: run_fuzzers.sh BUILD_DIR SECONDS_IN_ALL LANES      exit code 1 on a finding or when there is no fuzzer
set -u
build=$1 seconds=$2 lanes=$3
seeds=$(cd "$(dirname "$0")/../fuzz" && pwd)/seeds # seeds/<fuzzer's name>/: first inputs, where a fuzzer has some
mapfile -t fuzzers < <(find "$build/tests/fuzz" -maxdepth 1 -type f -name '*fuzz*' -perm -u+x | sort)
((${#fuzzers[@]} > 0)) || { echo "error: no fuzzers in $build/tests/fuzz"; exit 1; }
each=$((seconds * lanes / ${#fuzzers[@]}))
((each >= 1)) || each=1

fuzz() {
  local name corpus
  name=$(basename "$1")
  corpus="$build/corpus/$name"
  mkdir -p "$corpus" "$build/findings"
  local from=("$corpus")
  [[ -d $seeds/$name ]] && from+=("$seeds/$name")
  # -timeout: one input that takes 5 s counts as a hang, and fails.
  if "$1" -max_total_time="$each" -timeout=5 -rss_limit_mb=1024 -print_final_stats=1 \
       -artifact_prefix="$build/findings/$name-" "${from[@]}" >"$build/findings/$name.log" 2>&1; then
    echo "$name: $(grep -oE 'number_of_executed_units: *[0-9]+' "$build/findings/$name.log" | grep -oE '[0-9]+') inputs in $each s"
  else
    tail -n 30 "$build/findings/$name.log"
    echo "error: $name found a failure; the input is in $build/findings/"
    return 1
  fi
}
export -f fuzz
export build seeds each
printf '%s\n' "${fuzzers[@]}" | xargs -P "$lanes" -I{} bash -c 'fuzz {}'
