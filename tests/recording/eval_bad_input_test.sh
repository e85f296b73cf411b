#!/bin/sh
# eval_bad_input_test.sh PROGRAM FIXTURES [EMULATOR...]: an evaluation that cannot be done ends with one clear line and the
# documented exit code.
program=$1
planes=$2/planes
shift 2
emulator=$*
. "$(dirname "$0")/expect.sh"
damaged=$work/damaged

fresh() {
  rm -rf "$damaged"
  mkdir "$damaged"
  cp -r "$planes"/* "$damaged"
}

one="--limit 1 --methods focus"

# --- truth
fresh; rm -r "$damaged/depth"
refuse 3 'depth: holds no depth pictures' eval "$damaged" $one
fresh; printf 'no picture' >"$damaged/depth/000000050000.png"
refuse 4 '000000050000.png: ' eval "$damaged" $one
fresh; head -c 300 "$planes/depth/000000050000.png" >"$damaged/depth/000000050000.png"
refuse 4 '000000050000.png: is no good 16-bit grey PNG' eval "$damaged" $one
fresh; mv "$damaged/depth/000000050000.png" "$damaged/depth/first.png"
refuse 4 'first.png: the name of a depth picture is its time' eval "$damaged" $one
fresh; sed -i '/^\[grid\]/,/^\[ladder\]/{s/^width_px = 240/width_px = 200/;s/^cx_px = 121.5/cx_px = 100.0/}' "$damaged/camera.toml"
refuse 4 '000000050000.png: is 240x180 px; the working grid of camera.toml is 200x180 px' eval "$damaged" $one
refuse 2 'depth: none of the 43 depth pictures is of a tick' eval "$planes" $one --first-tick-us 50001
refuse 2 'depth: none of the 43 depth pictures is of a tick' eval "$planes" $one --first-tick-us 99999999
fresh; for picture in "$damaged"/depth/*; do mv "$picture" "$damaged/depth/9${picture##*/}"; done
refuse 7 'depth: none of the 43 depth pictures is before the last event, at 2148000 us' eval "$damaged" $one
fresh; mv "$damaged/depth/000000050000.png" "$damaged/depth/99999999999999999999.png"
refuse 4 '99999999999999999999.png: the name of a depth picture is its time' eval "$damaged" $one

# --- the recording
refuse 3 'nowhere: is no recording folder' eval "$work/nowhere"
fresh; rm "$damaged/can.log"
refuse 6 'no motion: .*can.log is missing' eval "$damaged" $one
fresh; echo 'this is no candump log' >"$damaged/can.log"
refuse 6 'can.log: no motion' eval "$damaged" $one

# --- methods and their inputs
run 2 'methods' eval "$planes" --methods best
refuse 2 'names a method twice' eval "$planes" --methods focus,focus
refuse 2 'rows.*need --prior FILE' eval "$planes" --methods rows
refuse 2 'maps.*needs --maps DIR' eval "$planes" --methods maps
refuse 3 'nothing.toml: cannot be opened' eval "$planes" --prior "$work/nothing.toml"
printf 'median_m = 2.0\nrow_depth_m = [2.0, 2.0]\n' >"$work/prior.toml"
refuse 5 'has 2 rows; the grid of .*planes has 180' eval "$planes" --prior "$work/prior.toml"
refuse 3 'nowhere: is no folder' eval "$planes" --maps "$work/nowhere" --methods maps
mkdir "$work/maps"
refuse 3 '000000050000.png: is missing. --maps needs a picture for each' eval "$planes" --maps "$work/maps" --methods maps
printf 'text' >"$work/maps/000000050000.png"
refuse 4 '000000050000.png: ' eval "$planes" --maps "$work/maps" --methods maps
run 0 '^maps ' eval "$planes" --maps "$planes/depth" --methods maps,median --limit 1
refuse 2 'two recordings are named planes' eval "$planes" "$planes" --out "$work/out"

mkdir -p "$work/taken/planes/old"
refuse 2 'taken/planes: is there already' eval "$planes" $one --out "$work/taken"
run 0 'planes: 1 of 43' eval "$planes" $one --out "$work/out"
[ -f "$work/out/planes/focus/000000050000.npy" ] || { echo "FAILED: --out wrote no map"; failures=$((failures + 1)); }
refuse 2 'out/planes: is there already' eval "$planes" $one --out "$work/out"

# --- numbers
for clip in 3 3:2 0:80 a:b 1:2x 1:inf; do refuse 2 'clip: must be two depths' eval "$planes" --clip $clip; done
run 2 'cut' eval "$planes" --cut -1
run 2 'limit' eval "$planes" --limit 0
run 2 'min-confidence' eval "$planes" --min-confidence 0
run 2 'velocity-noise' eval "$planes" --velocity-noise -3
run 2 'excludes' eval "$planes" --noise-study --velocity-noise 5
run 2 'excludes' eval "$planes" --fit-prior "$work/fitted.toml" --json "$work/scores.json"
run 2 'noise-kind' replay "$planes" --noise-kind sigma
run 3 'scores.json: cannot be written' eval "$planes" $one --json "$work/no/such/folder/scores.json"
printf 'a file' >"$work/occupied"
refuse 3 'cannot be made' eval "$planes" $one --out "$work/occupied"

# --- what is counted
run 0 'planes: 2 of 43 truth images' eval --limit 2 --methods focus,median "$planes"
run 0 'planes: 1 of 43 truth images compared, 0 of them before the first event; 1 after the last event, 0 of the time of another, 0 at no tick, 41 over the limit' eval "$planes" $one
run 0 'planes: 21 of 43 truth images compared.*; 1 after the last event, .* 21 at no tick, 0 over' eval "$planes" --methods median --rate 10
run 0 'planes: 13 of 43 truth images compared.*; 1 after the last event, .* 29 at no tick, 0 over' eval "$planes" --methods median --first-tick-us 1500000
# Truth off every grid, twice at one time, before the first event and after the last.
fresh
mv "$damaged/depth/000000600000.png" "$damaged/depth/000000600017.png"
cp "$damaged/depth/000000700000.png" "$damaged/depth/700000.png"
mv "$damaged/depth/000001900000.png" "$damaged/depth/000091900000.png"
cp "$damaged/depth/000000050000.png" "$damaged/depth/-50000.png"
run 0 'damaged: 42 of 45 truth images compared, 1 of them before the first event; 2 after the last event, 1 of the time of another, 0 at no tick, 0 over' eval "$damaged" --methods median
run 0 'damaged: 41 of 45 truth images compared.*; 2 after the last event, 1 of the time of another, 1 at no tick, 0 over' eval "$damaged" --methods median --rate 20
run 0 '43 images, median 1.852 m' eval --fit-prior "$work/fitted.toml" "$planes"
run 0 '^rows +2 ' eval "$planes" --prior "$work/fitted.toml" --methods rows --limit 2
run 0 'planes: 12 of' eval "$planes" --limit 12 --methods focus,median --curve "$work/curve.svg"
[ "$(grep -c '<polyline' "$work/curve.svg")" -eq 2 ] || { echo "FAILED: curve.svg has not two curves"; failures=1; }
run 0 '^overall: 2 of 86 truth images' eval "$planes" "$planes" $one
run 0 '^ +100 ' eval "$planes" --noise-study --methods focus --limit 2

finish
