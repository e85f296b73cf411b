# A camera and a bus at the speed of their recording: depth at 2 Hz on the host's clock, nothing lost on the way.
# modules: can can-raw vcan vhci-hcd
# programs: hil_play_robot hil_depth egofocusd
# files: fixtures/town5_night/events.raw fixtures/town5_night/can.log fixtures/town5_night/camera.toml
# files: fixtures/town5_night/robot.dbc tests/hil/daemon_steps.sh
# clock: instructions
# limit: 300
. ./daemon_steps.sh
for module in can-raw vcan vhci-hcd; do modprobe $module || exit 1; done
ip link add dev vcan0 type vcan && ip link set vcan0 up || exit 1
start_robot davis vcan0
configure usb vcan0 real 'backend = "focus"' 'rate_hz = 2' 'lateness_us = 100000'
sed -i 's/^hypotheses = 64/hypotheses = 32/' robot.toml # a tick then takes 0.3 s of the guest's time
start_daemon
failed=0
hil_depth depth.sock 5 with-depth || failed=1
egofocusd --config daemon.toml --ask health
for loss in camera_lost camera_device_dropped events_ring_dropped can_kernel_dropped ticks_skipped; do
  [ "$(health $loss)" = 0 ] || { echo "FAILED $loss is $(health $loss)"; failed=1; }
done
stop_daemon || failed=1
exit $failed
