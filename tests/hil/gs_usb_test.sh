# The SocketCAN source on an emulated USB adapter.
# modules: can can-raw can-dev vhci-hcd gs_usb
# programs: hil_gs_usb
hil_gs_usb
