#!/bin/sh
# command_line_test.sh PROGRAM FIXTURES [EMULATOR...]: exit codes and messages of the command line on bad input.
program=$1
fixtures=$2
shift 2
emulator=$*
. "$(dirname "$0")/expect.sh"

run 0 'Examples:' --help
run 0 '^egofocus [0-9]+\.[0-9]+' --version
run 2 'subcommand is required'
run 2 'Run with --help' frobnicate
run 0 'kind +model' info
run 2 'is for --backend network alone' replay "$fixtures/planes" --backend focus --model x.efm
run 2 'are for --backend focus alone' replay "$fixtures/planes" --backend network --cost sti
run 2 'no other one beside' replay "$fixtures/planes" --no-smoothing --with-focus
run 0 'conv_u8s8 ' replay "$fixtures/planes" --first-tick-us 900000 --ticks 1 --model "$fixtures/network/model.efm"
run 0 'backend +focus' replay "$fixtures/planes" --first-tick-us 900000 --ticks 1 --cost sti
run 3 'nowhere.efm' replay "$fixtures/planes" --model "$work/nowhere.efm"
run 3 'nowhere: cannot be read' info "$work/nowhere"
run 0 '"events": 408074,' info "$fixtures/planes" --json
run 0 'BODY_MOTION' info "$fixtures/planes/vehicle.dbc"
run 0 'kind +poses' info "$fixtures/planes/poses.txt"

: >"$work/empty.raw"
run 4 'is empty' info "$work/empty.raw"
printf 'hello world, this is prose\n' >"$work/prose.txt"
run 4 'of no known kind' info "$work/prose.txt"
printf '%% no format here\n%% end\n' >"$work/bad.raw"
run 4 'bad.raw' info "$work/bad.raw"
head -c 1001 "$fixtures/planes/events.raw" >"$work/cut.raw"
run 0 'cut_off_bytes +1' info "$work/cut.raw"
printf '[camera]\nwidth = 3\n' >"$work/camera.toml"
run 5 'camera.toml:' info "$work/camera.toml"
printf '0 0 0 0 0 0 0 1\n0 0 0 0 0 0 0 1\n' >"$work/poses.txt"
run 4 'poses.txt:2: time' info "$work/poses.txt"
mkdir "$work/folder"
run 3 'camera.toml' info "$work/folder"
cp "$fixtures/planes/camera.toml" "$fixtures/planes/events.raw" "$fixtures/planes/vehicle.dbc" "$work/folder"
run 6 'no motion' info "$work/folder"
run 3 'neither events.txt' convert "$work/folder" "$work/out"
run 2 'must look like' convert "$work/folder" "$work/out" --size 24
run 2 'number of seconds' convert "$work/folder" "$work/out" --t0 noon
run 0 'Examples:' convert --help
run 2 'rosbag not in' convert "$work/folder" "$work/out" --format rosbag
refuse 3 'nowhere: cannot be opened' convert "$work/nowhere" "$work/out"
refuse 4 'no known layout' convert "$work/prose.txt" "$work/out"
printf '#!AER-DAT4.0\r\n' >"$work/short.aedat4"
refuse 4 'short.aedat4: is cut off' convert "$work/short.aedat4" "$work/out"
mkdir "$work/set"
printf '0.1 10 20 1\n' >"$work/set/events.txt"
printf '199.5 200 120 90\n' >"$work/set/calib.txt"
printf '0 0 0 0 0 0 0 1\n0.2 1 0 0 0 0 0 1\n' >"$work/set/groundtruth.txt"
run 0 '"events": 1,.*"poses": 2,' convert "$work/set" "$work/out" --json
refuse 2 'calibration of its own' convert "$work/set" "$work/out2" --kalibr "$work/k.yaml"
refuse 2 'has one camera' convert "$work/set" "$work/out2" --camera right
refuse 2 'already holds a recording' convert "$work/set" "$work/out"
[ ! -e "$work/out.partial" ] || { echo "FAILED: out.partial is left"; failures=$((failures + 1)); }

finish
