#!/bin/sh
# overlay_test.sh PROGRAM FIXTURES [EMULATOR...]: pictures that lay events over frames and depth; bad input.
program=$1
fixtures=$2
shift 2
emulator=$*
. "$(dirname "$0")/expect.sh"

run 0 'depth_pictures +2' overlay "$fixtures/planes" --out "$work/overlay" --limit 2
run 0 'kind +PNG' info "$work/overlay/000000050000.png"
[ "$(ls "$work/overlay" | wc -l)" -eq 2 ] || { echo "FAILED: not two overlays"; failures=$((failures + 1)); }
mkdir -p "$work/seen/pictures/grey"
cp -r "$fixtures/planes/depth" "$fixtures/planes/camera.toml" "$fixtures/planes/events.raw" "$work/seen" # no motion
run 0 'frames +0' overlay "$work/seen" --out "$work/overlay2" --limit 1
cp "$work/overlay/000000050000.png" "$work/seen/pictures/grey"
refuse 4 'grey/000000050000.png: is no good 8-bit grey PNG' overlay "$work/seen" --out "$work/overlay2" --limit 1
rm -r "$work/seen/depth"
refuse 3 'depth: holds no depth pictures' overlay "$work/seen" --out "$work/overlay2"
refuse 3 'nowhere: is no recording folder' overlay "$work/nowhere" --out "$work/overlay2"
run 2 'around-us' overlay "$work/seen" --out "$work/overlay2" --around-us -1

finish
