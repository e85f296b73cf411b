#!/bin/busybox sh
# The first process of a guest: mounts, runs /test/run, tells its output and exit code through the port "out".
/bin/busybox --install -s /bin
export PATH=/test:/bin HOME=/ TMPDIR=/tmp
mount -t proc proc /proc
mount -t sysfs sysfs /sys
mount -t devtmpfs dev /dev
mkdir -p /dev/pts /dev/shm /run /tmp
mount -t devpts devpts /dev/pts
for folder in /run /tmp /dev/shm; do mount -t tmpfs tmpfs $folder; done
echo /bin/modprobe >/proc/sys/kernel/modprobe
for module in virtio_pci virtio_console; do modprobe -q $module; done
ip link set lo up

out=/dev/console
for try in $(seq 100); do
  port=$(grep -lx out /sys/class/virtio-ports/*/name 2>/dev/null) && out=/dev/$(basename "$(dirname "$port")") && break
  usleep 20000
done
exec 3>$out # the port has one opener, and a test may leave processes behind
cd /test
sh ./run >&3 2>&1 </dev/null
code=$?
read -r seconds rest </proc/uptime
printf '\n@@guest exit %s after %s s\n' $code "$seconds" >&3
poweroff -f
