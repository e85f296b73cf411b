#!/bin/sh
# full_disk_test.sh PROGRAM FIXTURES: on a full disk there is one clear line, exit code 3, and nothing half-written that
# looks whole. Small file systems need root; without it that part is skipped, and the exit code is 77.
program=$1
planes=$2/planes
emulator=
. "$(dirname "$0")/expect.sh"
. "$(dirname "$0")/small_disk.sh"
one="--limit 1 --methods focus"

# --- a device that is always full
if [ -c /dev/full ]; then
  refuse 3 '/dev/full: cannot be written \(No space left on device\)' replay "$planes" --ticks 1 --golden /dev/full
  refuse 3 '/dev/full: cannot be written \(No space left on device\)' eval "$planes" --fit-prior /dev/full
  for option in --json --curve; do
    run 3 '/dev/full: cannot be written \(No space left on device\)' eval "$planes" $one $option /dev/full
  done
  for arguments in --help --version "info $planes" "replay $planes --ticks 1" "eval $planes $one"; do
    "$program" $arguments >/dev/full 2>"$work/output"
    expect_output 3 'standard output: cannot be written' $? "$arguments >/dev/full"
  done
  expect_true "/dev/full is a device no more" [ -c /dev/full ]
fi
"$program" eval "$planes" $one --json /dev/stdout | cat >"$work/both"
expect_true "--json /dev/stdout and the table are not both in the standard output" \
  grep -q '^focus ' "$work/both"
expect_true "--json /dev/stdout is not in the standard output" grep -q '"cut_m"' "$work/both"

# --- files replace others whole, or not at all; links stay links
printf 'old' >"$work/target.json"
ln -s target.json "$work/link.json"
run 0 'planes: ' eval "$planes" $one --json "$work/link.json"
expect_true "the link became a file" [ -L "$work/link.json" ]
expect_true "the link's target was not written" grep -q '"cut_m"' "$work/target.json"

# --- small file systems
if ! small_disk 300; then finish_skipped; fi
mkdir "$work/set"
awk 'BEGIN { for (i = 0; i < 200000; i++) printf "%.6f %d %d %d\n", i * 5e-6, i * 37 % 240, i * 53 % 180, i % 2 }' \
  >"$work/set/events.txt"
printf '199.5 200 120 90\n' >"$work/set/calib.txt"
printf '0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n' >"$work/set/groundtruth.txt"
refuse 3 'disk/out.partial/events.raw: cannot be written' convert "$work/set" "$disk/out"
expect_true "convert left something" is_empty "$disk"

refuse 3 'cannot be written \(No space left on device\)' eval "$planes" --limit 3 --methods focus --out "$disk/maps"
expect_true "eval --out left maps" [ -z "$(find "$disk" -name '*.npy*')" ]

small_disk 300
fill_disk
printf 'old' >"$disk/scores.json" || echo "note: not even three bytes fit"
printf 'old' >"$work/old"
run 3 'scores.json: cannot be written \(No space left on device\)' eval "$planes" $one --json "$disk/scores.json"
run 3 'curve.svg: cannot be written \(No space left on device\)' eval "$planes" $one --curve "$disk/curve.svg"
refuse 3 'golden.txt: cannot be written \(No space left on device\)' replay "$planes" --ticks 1 --golden "$disk/golden.txt"
expect_true "a failed write left something" \
  [ "$(ls -A "$disk" | sort | tr '\n' ' ')" = "filler scores.json " ]
expect_true "what was there before is gone" cmp -s "$work/old" "$disk/scores.json"

small_disk 300
mkdir "$disk/pictures"
printf 'old' >"$disk/pictures/report.json"
printf 'old' >"$disk/pictures/overview.png"
refuse 3 'png: cannot be written \(No space left on device\)' replay "$planes" --first-tick-us 500000 --out "$disk/pictures"
expect_true "a replay that was cut off has a report" [ ! -e "$disk/pictures/report.json" ]
expect_true "a replay that was cut off has an overview" [ ! -e "$disk/pictures/overview.png" ]
expect_true "a replay left a half picture" [ -z "$(find "$disk" -name '*.partial')" ]
expect_true "a replay left no whole picture" [ -n "$(find "$disk" -name '*.png')" ]
for picture in "$disk"/pictures/*.png; do
  expect_true "$picture is not whole" sh -c "tail -c 8 '$picture' | grep -q IEND"
done

finish
