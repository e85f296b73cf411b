# For the tests of the command line: sourced with PROGRAM and [EMULATOR...] set up by the caller.
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failures=0

# run CODE PATTERN ARGUMENT...: the program's exit code, and an extended pattern in what it prints.
run() {
  code=$1
  pattern=$2
  shift 2
  $emulator "$program" "$@" >"$work/output" 2>&1
  got=$?
  if [ "$got" -ne "$code" ] || ! grep -Eq "$pattern" "$work/output"; then
    echo "FAILED: $* (exit $got, wanted $code; wanted text: $pattern)"
    sed 's/^/  | /' "$work/output"
    failures=$((failures + 1))
  fi
}

# refuse CODE PATTERN ARGUMENT...: the same, and the message is one line.
refuse() {
  run "$@"
  if [ "$(wc -l <"$work/output")" -ne 1 ]; then
    echo "FAILED: $*: not one line:"
    sed 's/^/  | /' "$work/output"
    failures=$((failures + 1))
  fi
}

finish() {
  [ "$failures" -eq 0 ] && echo "all passed"
  exit "$failures"
}
