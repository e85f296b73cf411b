"""Boots a guest under emulation, runs one script in it, and gives back its output and exit code."""
import pathlib
import re
import subprocess
import tempfile

from initrd import Archive, Modules, add_libraries
from guest_system import find_busybox, find_modules

HERE = pathlib.Path(__file__).parent
# mitigations, integrity and audit cost boot time and prove nothing here.
KERNEL_WORDS = ("panic=-1 quiet loglevel=4 mitigations=off nokaslr audit=0 apparmor=0 selinux=0 nowatchdog "
                "random.trust_cpu=on cryptomgr.notests")
QEMU = {
    "amd64": ["qemu-system-x86_64", "-machine", "q35,hpet=off,vmport=off", "-cpu", "max"],
    # Pointer authentication as the architecture defines it costs several seconds of emulation at boot.
    "arm64": ["qemu-system-aarch64", "-machine", "virt,gic-version=3", "-cpu", "max,pauth-impdef=on"],
}
CONSOLES = {"amd64": "console=ttyS0 tsc=reliable no_timer_check", "arm64": "console=ttyAMA0"}
# The guest's time. host: it goes on while this machine does something else. instructions: a nanosecond for each that
# the guest executes, and sleeping costs nothing, so that nothing is ever late because the host was busy.
CLOCKS = {
    "host": ["-accel", "tcg,thread=multi,tb-size=256"],
    "instructions": ["-accel", "tcg,thread=single,tb-size=256", "-icount", "shift=0,sleep=off"],
}
NO_EXIT_LINE = 125  # the guest died
TIME_OUT = 124


def pack(system, arch, script, programs, modules, files):
    """The guest's file system. `files`: name in /test -> bytes."""
    archive = Archive()
    for name in ("dev", "proc", "sys", "run", "tmp", "mnt", "bin", "lib"):
        archive.folder(name)
    archive.file("init", (HERE / "guest_init.sh").read_bytes(), True)
    archive.file("bin/busybox", find_busybox(system).read_bytes(), True)
    Modules(find_modules(system)).add_to(archive, modules)
    for program in programs:
        archive.file(f"test/{program.name}", program.read_bytes(), True)
    add_libraries(archive, arch, programs, system / "root")
    for name, data in files.items():
        archive.file(f"test/{name}", data)
    archive.file("test/run", script.encode(), True)
    return archive.bytes()


def run(system, arch, initrd, limit_s, clock="host", qemu_words=(), memory_mib=512):
    """(exit code, output, kernel log). The code is the script's; 124: over its time; 125: the guest died."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "initrd").write_bytes(initrd)
        command = [*QEMU[arch], *CLOCKS[clock], "-smp", "1", "-m", str(memory_mib),
                   "-nodefaults", "-display", "none", "-no-reboot", "-kernel", str(system / "kernel"),
                   "-initrd", str(folder / "initrd"), "-serial", f"file:{folder}/kernel.log",
                   "-device", "virtio-serial-pci", "-chardev", f"file,id=out,path={folder}/out",
                   "-device", "virtserialport,chardev=out,name=out",
                   "-append", f"{KERNEL_WORDS} {CONSOLES[arch]}", *qemu_words]
        timed_out = False
        try:
            qemu = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=limit_s)
            complaint = qemu.stderr
        except subprocess.TimeoutExpired:
            timed_out, complaint = True, ""

        def text_of(path):
            return path.read_bytes().decode(errors="replace").replace("\r", "") if path.exists() else ""

        output, kernel_log = text_of(folder / "out"), text_of(folder / "kernel.log") + complaint
    last = re.findall(r"^@@guest exit (\d+) after (.*)$", output, re.M)
    output = re.sub(r"\n?@@guest exit .*\n", "", output)
    if last:
        return int(last[-1][0]), output, kernel_log
    return TIME_OUT if timed_out else NO_EXIT_LINE, output, kernel_log
