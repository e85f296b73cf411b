#!/bin/sh
# full_disk_test.sh CITYSIM: a disk that fills up ends a recording and a cache of samples with one clear line and exit code
# 3; nothing half-written looks whole, and with more room the same command goes on. Needs root; else skipped with 77.
program=$1
emulator=
. "$(dirname "$0")/../recording/expect.sh"
. "$(dirname "$0")/../recording/small_disk.sh"

if [ -c /dev/full ]; then
  for arguments in --help --version "desk --help"; do
    "$program" $arguments >/dev/full 2>"$work/output"
    expect_output 3 'standard output: cannot be written' $? "$arguments >/dev/full"
  done
fi
if ! small_disk 8; then finish_skipped; fi

small="--size 96x72 --frames 60 --seed 5"
refuse 3 'town.partial/.*: cannot be (written|made) ' desk --out "$disk/town" $small
expect_true "a recording that never began left something" is_empty "$disk"

# Full within the first piece of work, within the second, and at the texts at the end.
run 0 'views' desk --out "$work/whole" $small
whole_kib=$(du -sk --apparent-size "$work/whole" | cut -f 1)
for kib in 300 $((whole_kib * 3 / 4)) $((whole_kib + 60)); do
  small_disk "$kib"
  refuse 3 'town.partial/.*: cannot be written' desk --out "$disk/town" $small
  expect_true "a cut-off recording has its final name ($kib KiB)" [ ! -e "$disk/town" ]
  expect_true "no partial folder to go on with ($kib KiB)" [ -e "$disk/town.partial/resume.bin" ]
  mount -o remount,size=40m "$disk"
  run 0 'resumed_at' desk --out "$disk/town" $small
  diff -r "$work/whole" "$disk/town" >"$work/output" 2>&1
  expect_true "going on after a full disk changes the bytes ($kib KiB): $(head -n 3 "$work/output")" [ ! -s "$work/output" ]
  expect_true "a partial folder is left ($kib KiB)" [ ! -e "$disk/town.partial" ]
done

small_disk 300
samples="--count 64 --seed 3 --size 64x64 --families desk"
refuse 3 'shard_000000.egs: cannot be written \(No space left on device\)' samples --out "$disk/cache" $samples
expect_true "a cut-off cache holds a shard" [ "$(ls -A "$disk/cache")" = samples.txt ]
mount -o remount,size=40m "$disk"
run 0 '"shards_made": 1' samples --out "$disk/cache" $samples --json
if [ -c /dev/full ]; then
  "$program" samples --out "$disk/cache" $samples --stdout >/dev/full 2>"$work/errors"
  code=$?
  head -n 1 "$work/errors" >"$work/output"
  expect_output 3 'standard output' $code "samples --stdout >/dev/full"
fi
small_disk 8
fill_disk
rm -f "$disk/filler" && head -c 8192 /dev/zero >"$disk/filler"
refuse 3 'cannot be (written|made)' samples --out "$disk/cache" $samples
expect_true "a half samples.txt is left" [ ! -e "$disk/cache/samples.txt" ]

finish
