# The bus of fixtures/planes, played at real speed on a virtual bus.
# modules: can can-raw vcan
# programs: hil_can_playback hil_play_can
# files: fixtures/planes/can.log fixtures/planes/vehicle.dbc
modprobe can-raw && modprobe vcan
ip link add dev vcan0 type vcan && ip link set vcan0 mtu 72 && ip link set vcan0 up
hil_can_playback
