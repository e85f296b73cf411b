#!/bin/sh
# replay_bad_input_test.sh PROGRAM FIXTURES [EMULATOR...]: a replay of damaged recordings ends with one clear line and the
# documented exit code, or goes on and counts what it dropped.
program=$1
planes=$2/planes
shift 2
emulator=$*
. "$(dirname "$0")/expect.sh"
damaged=$work/damaged

# A fresh copy, to be damaged.
fresh() {
  rm -rf "$damaged"
  mkdir "$damaged"
  cp "$planes"/*.* "$damaged"
}

# edit FILE SED_SCRIPT: fails the test when nothing changed.
edit() {
  fresh
  sed -i "$2" "$damaged/$1"
  if cmp -s "$planes/$1" "$damaged/$1"; then
    echo "FAILED: $1 has nothing to change by $2"
    failures=$((failures + 1))
  fi
}

# --- files that are missing, cut off, or not what they should be
refuse 3 'nowhere: is no recording folder' replay "$work/nowhere"
fresh; rm "$damaged/camera.toml"
refuse 3 'camera.toml: cannot be opened' replay "$damaged"
fresh; rm "$damaged/events.raw"
refuse 3 'events.raw: cannot be read: ' replay "$damaged"
fresh; : >"$damaged/events.raw"
refuse 7 'events.raw: is empty' replay "$damaged"
fresh; head -c 30 "$planes/events.raw" >"$damaged/events.raw"
refuse 4 'events.raw: bad header' replay "$damaged"
edit events.raw '1,5d'
refuse 4 'events.raw: bad header' replay "$damaged"
fresh; head -n 5 "$planes/events.raw" >"$damaged/events.raw"
refuse 7 'events.raw: holds no events' replay "$damaged"
fresh; head -c 100001 "$planes/events.raw" >"$damaged/events.raw"
run 0 'cut_off_bytes +1$' replay "$damaged"

# --- configuration
edit camera.toml '0,/width_px = 240/s//width_px = 346/'
refuse 5 'camera.toml: says 346x180 px, but .*events.raw is 240x180' replay "$damaged"
edit camera.toml 's/^fx_px = 200.0/fx_px = -1.0/'
refuse 5 'camera.toml: intrinsics do not fit' replay "$damaged"
edit camera.toml 's/^hypotheses = 64/hypotheses = 65/'
refuse 5 'camera.toml: .*ladder.hypotheses .*65' replay "$damaged"
edit vehicle.dbc 's/GyroZ/YawRate/'
refuse 5 'vehicle.dbc: the DBC has no such signal: gyro_z' replay "$damaged"
edit vehicle.dbc 's/^BO_ 372/BO_ what/'
refuse 4 'vehicle.dbc: cannot parse line' replay "$damaged"
fresh; rm "$damaged/vehicle.dbc"
refuse 3 'vehicle.dbc: cannot be opened' replay "$damaged"

# --- motion
fresh; rm "$damaged/can.log"
refuse 6 'no motion: .*can.log is missing or empty' replay "$damaged"
fresh; rm "$damaged/poses.txt"
refuse 6 'no motion: .*poses.txt is missing' replay "$damaged" --motion poses
fresh; echo 'this is no candump log' >"$damaged/can.log"
refuse 6 'can.log: no motion' replay "$damaged" --ticks 2
edit can.log 's/#/0#/'
refuse 6 'can.log: no motion' replay "$damaged" --ticks 2
edit poses.txt '200,230d'
refuse 6 'poses.txt: no pose between 0.985000 s and 1.145000 s' replay "$damaged" --motion poses
edit poses.txt '200s/^0.99/0.19/'
refuse 4 'poses.txt:200: time goes backwards' replay "$damaged" --motion poses
edit poses.txt '7s/ /,/g'
refuse 4 'poses.txt:7: ' replay "$damaged" --motion poses

# --- times: two stretches of the events change places; what comes too late is dropped and counted
fresh
{
  head -c 500000 "$planes/events.raw"
  tail -c +700001 "$planes/events.raw" | head -c 200000
  tail -c +500001 "$planes/events.raw" | head -c 200000
  tail -c +900001 "$planes/events.raw"
} >"$damaged/events.raw"
run 0 'out_of_order +[1-9][0-9]+$' replay "$damaged"
run 0 'late +[1-9][0-9]+$' replay "$damaged"
run 0 'event_stream_violations +[1-9][0-9]*$' replay "$damaged"
refuse 7 'first-tick-us 99999999: the last event is at 2148000 us' replay "$planes" --first-tick-us 99999999

# --- options
refuse 2 'unknown instruction set sse9' replay "$planes" --isa sse9
run 2 'Run with --help' replay "$planes" --cost best
refuse 5 'number of threads' replay "$planes" --threads 99
refuse 5 'rate.rate_hz' replay "$planes" --rate 0
refuse 3 'cannot be' replay "$planes" --ticks 1 --golden "$work/no/such/folder"

finish
