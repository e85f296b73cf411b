# For tests of full disks: sourced after expect.sh. $disk is where small_disk mounts.
disk=$work/disk
mkdir "$disk"
trap 'umount "$disk" 2>/dev/null; rm -rf "$work"' EXIT
trap 'exit 1' INT TERM # by way of the line above

# small_disk KIBIBYTES: an empty file system of this size at $disk; false where that is not permitted.
small_disk() {
  umount "$disk" 2>/dev/null
  mount -t tmpfs -o "size=${1}k" tmpfs "$disk" 2>"$work/mount" && return 0
  echo "skipped: small file systems cannot be mounted here ($(head -n 1 "$work/mount"))"
  return 1
}

# Leaves the rest of one page for files, which is less than any of ours needs.
fill_disk() {
  cat /dev/zero >"$disk/filler" 2>/dev/null
  truncate -s -4096 "$disk/filler"
}

is_empty() { [ -z "$(ls -A "$1")" ]; }

# expect_true WHAT_IS_WRONG COMMAND...
expect_true() {
  wrong=$1
  shift
  "$@" && return
  echo "FAILED: $wrong"
  failures=$((failures + 1))
}

# expect_output CODE PATTERN GOT WHAT: what a command that was run by hand left in $work/output, one line.
expect_output() {
  if [ "$3" -ne "$1" ] || ! grep -Eq "$2" "$work/output" || [ "$(wc -l <"$work/output")" -ne 1 ]; then
    echo "FAILED: $4 (exit $3, wanted $1; wanted text: $2)"
    sed 's/^/  | /' "$work/output"
    failures=$((failures + 1))
  fi
}

finish_skipped() {
  [ "$failures" -eq 0 ] && exit 77
  exit "$failures"
}
