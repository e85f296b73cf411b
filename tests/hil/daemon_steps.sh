# Steps that tests of the daemon share; sourced in the guest.
PATH=$PWD:$PATH

# configure EVENTS CAN CLOCK [LINE of [engine] ...]: daemon.toml and robot.toml for the recording in this folder.
configure() {
  events=$1 can=$2 clock=$3
  shift 3
  sed "s|^events = 65536|events = 524288|" camera.toml >robot.toml # what comes in half a second and a tick
  [ "$events" = v4l2 ] && printf '\n[v4l2]\ndevice = "/dev/video0"\nformat = "evt3"\nsilence_ms = 0\n' >>robot.toml
  cat >daemon.toml <<TOML
[source]
events = "$events"
motion = "can"
clock = "$clock"
$([ "$clock" = device ] && printf 'first_tick_us = %s\nwait_for_reader = true\n' "$FIRST_TICK_US")
[can]
interface = "$can"
[engine]
camera = "robot.toml"
$(printf '%s\n' "$@")
[depth]
socket = "depth.sock"
slots = 64
[control]
socket = "control.sock"
TOML
}

# start_robot CAMERA BUS ...: see play_robot.cpp.
start_robot() {
  hil_play_robot "$@" &
  robot=$!
}
stop_robot() {
  kill $robot
  wait $robot
}

# Once the kernel has the devices: starts the daemon.
start_daemon() {
  until egofocusd --config daemon.toml --check-config >check.log 2>&1; do usleep 300000; done
  egofocusd --config daemon.toml &
  daemon=$!
  until [ -S depth.sock ]; do usleep 100000; done
}

stop_daemon() {
  kill -TERM $daemon
  wait $daemon
  code=$?
  echo "the daemon ended with $code"
  return $code
}

# health KEY: a number of its health.
health() {
  egofocusd --config daemon.toml --ask health | grep -o "\"$1\": *[0-9-]*" | grep -o '[0-9-]*$'
}
