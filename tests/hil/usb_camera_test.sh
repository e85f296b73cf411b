# The USB camera source over libusb on the kernel's USB stack, against an emulated DAVIS346.
# modules: usbcore usbip-core vhci-hcd
# programs: hil_usb_camera
# clock: instructions
# limit: 300
modprobe vhci-hcd || exit 1
hil_usb_camera
