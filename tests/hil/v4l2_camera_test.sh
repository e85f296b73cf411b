# The V4L2 source on the kernel's uvcvideo driver, against an emulated event sensor.
# modules: vhci-hcd uvcvideo
# programs: hil_v4l2_camera
# clock: instructions
# limit: 300
modprobe vhci-hcd && modprobe uvcvideo || exit 1
hil_v4l2_camera
