# The USB camera source over libusb on the kernel's USB stack, against an emulated EVK4.
# modules: usbcore usbip-core vhci-hcd
# programs: hil_evk4
# clock: instructions
# limit: 300
modprobe vhci-hcd || exit 1
hil_evk4
