# The SocketCAN source on a virtual bus.
# modules: can can-raw vcan
# programs: hil_vcan
hil_vcan
