# By the devices' time the daemon gives byte for byte what `egofocus replay` gives of the same recording.
# modules: can can-raw can-dev vhci-hcd gs_usb uvcvideo
# programs: hil_play_robot hil_depth egofocusd
# files: fixtures/town5_night/events.raw fixtures/town5_night/can.log fixtures/town5_night/camera.toml
# files: fixtures/town5_night/robot.dbc tests/hil/daemon_steps.sh tests/golden/town5_night.txt
# files: tests/golden/town5_night_base.txt tests/golden/town5_night_small.txt models/base/base.efm models/small/small.efm
# clock: instructions
# limit: 560
. ./daemon_steps.sh
FIRST_TICK_US=1000000
date -s @1000 >/dev/null # the adapter's stamps become the recording's times (hil_play_robot)
for module in can-raw vhci-hcd gs_usb uvcvideo; do modprobe $module || exit 1; done

# equals TEXT: as many frames as the committed replay has, each of the same hash.
equals() {
  awk '$1 == "tick" { print $4, $12 }' "$1" >expected
  hil_depth depth.sock "$(wc -l <expected)" >frames || { echo "no depth: $?"; cat frames; return 1; }
  awk '{ print $2, $4 }' frames >got
  cmp expected got && echo "ok     $1: $(wc -l <got) frames" && return
  echo "FAILED $1"
  cat frames expected
  return 1
}

failed=0
# run EVENTS TEXT [LINE of [engine] ...]
run() {
  events=$1 text=$2
  shift 2
  configure $events can0 device "$@"
  start_daemon
  equals "$text" || failed=1
  for loss in events_ring_dropped can_kernel_dropped; do
    [ "$(health $loss)" = 0 ] || { echo "FAILED $loss is $(health $loss)"; failed=1; }
  done
  stop_daemon || failed=1
}
start_robot v4l2 adapter depth.sock $FIRST_TICK_US
run v4l2 town5_night.txt 'backend = "focus"'
run v4l2 town5_night_small.txt 'model = "small.efm"'
stop_robot
start_robot davis adapter
run usb town5_night_base.txt 'model = "base.efm"'
exit $failed
