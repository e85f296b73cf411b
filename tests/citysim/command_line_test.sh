#!/bin/sh
# command_line_test.sh CITYSIM EGOFOCUS: what citysim writes, how it goes on, and what it says to bad input.
program=$1
egofocus=$2
emulator=
. "$(dirname "$0")/../recording/expect.sh"

run 0 'Families:' --help
run 0 '^citysim [0-9]+\.[0-9]+' --version
run 2 'Families:'
run 0 'Examples:' town1 --help
run 0 'Examples:' samples --help
run 0 'textureless' stats --help
refuse 2 "'town9' is no family|'town9': is no family" town9 --out "$work/a"
run 2 'out is required' town1
run 2 'frames' town1 --out "$work/a" --frames 0
refuse 2 'must look like' town1 --out "$work/a" --size 3x3
refuse 2 'must look like' town1 --out "$work/a" --size big
refuse 2 'is no family' samples --out "$work/a" --families town1 moon
refuse 3 'cannot be made' desk --out /proc/nowhere --frames 1
[ -e "$work/a" ] && { echo "FAILED: a refused command left something behind"; failures=$((failures + 1)); }

small="--size 96x72 --frames 3 --seed 5"
run 0 'views' desk --out "$work/one" $small --threads 1
run 0 'views' desk --out "$work/two" $small --threads 3
diff -r "$work/one" "$work/two" >"$work/output" || { echo "FAILED: threads change the bytes"; cat "$work/output"; failures=$((failures + 1)); }
refuse 2 'is there already' desk --out "$work/one" $small
[ "$(ls "$work/one/depth" | wc -l)" -eq 3 ] || { echo "FAILED: not three depth pictures"; failures=$((failures + 1)); }
[ -e "$work/one.partial" ] && { echo "FAILED: a partial folder is left"; failures=$((failures + 1)); }
"$egofocus" replay "$work/one" --json >"$work/output" 2>&1 || { echo "FAILED: no replay"; cat "$work/output"; failures=$((failures + 1)); }

# Interrupted, by a limit on the size of files: the partial folder is no recording, and the same command ends it.
sh -c "ulimit -f 12; exec '$program' desk --out '$work/cut' --size 96x72 --frames 200 --seed 5" >"$work/output" 2>&1
[ -e "$work/cut" ] && { echo "FAILED: a cut-off recording has its final name"; failures=$((failures + 1)); }
run 0 'resumed_at' desk --out "$work/whole" --size 96x72 --frames 200 --seed 5
timeout -s KILL 1 "$program" desk --out "$work/killed" --size 96x72 --frames 200 --seed 5 >/dev/null 2>&1
if [ -e "$work/killed.partial" ]; then
  refuse 2 'other arguments' desk --out "$work/killed" --size 96x72 --frames 201 --seed 5
else
  echo "note: this machine is too fast to be interrupted"
fi
[ -e "$work/killed" ] || run 0 'resumed_at' desk --out "$work/killed" --size 96x72 --frames 200 --seed 5
diff -r "$work/whole" "$work/killed" >"$work/output" || { echo "FAILED: going on changes the bytes"; cat "$work/output"; failures=$((failures + 1)); }

finish
