"""Debian's kernels and busybox for the guests: downloaded, unpacked and kept in build/hil/<arch>.

Packages come through apt with a state of its own, so that neither root is needed nor a foreign architecture added to
this machine. Kernels are Debian's own, signed by it; apt checks them.
"""
import lzma
import os
import pathlib
import shutil
import struct
import subprocess
import tarfile

ARCHES = ("amd64", "arm64")
SUITE = "bookworm"
KEYRING = "/usr/share/keyrings/debian-archive-keyring.gpg"
# What is kept of a kernel's modules; the rest is most of its 400 MB.
MODULE_FOLDERS = ("net", "lib", "crypto", "fs/configfs", "drivers/net/can", "drivers/net/mii", "drivers/usb", "drivers/media",
                  "drivers/virtio", "drivers/char", "drivers/i2c", "drivers/input", "drivers/tty", "drivers/base",
                  "drivers/dma-buf", "drivers/hid")


def repositories():
    """(URI, suite) of Debian's archives: those that this machine's own apt knows, or below EGOFOCUS_DEBIAN_MIRROR."""
    wanted = (SUITE, f"{SUITE}-updates", f"{SUITE}-security")
    mirror = os.environ.get("EGOFOCUS_DEBIAN_MIRROR")
    if mirror:
        return [(f"{mirror}/debian-security" if suite.endswith("-security") else f"{mirror}/debian", suite) for suite in wanted]
    known = subprocess.run(["apt-get", "indextargets", "--format", "$(REPO_URI) $(RELEASE)", "Created-By: Packages"], text=True,
                           stdout=subprocess.PIPE, check=False).stdout.split("\n")
    found = sorted({tuple(line.split()) for line in known if line.split()[1:] and line.split()[1] in wanted})
    if not any(suite == SUITE for _, suite in found):
        raise SystemExit(f"error: this machine's apt knows no archive of Debian {SUITE}: set EGOFOCUS_DEBIAN_MIRROR to one.")
    return found


class Apt:
    """apt-get and apt-cache for one architecture, under `folder`."""

    def __init__(self, folder, arch):
        folder = folder.resolve()
        for name in ("etc", "state/lists/partial", "cache/archives/partial"):
            (folder / name).mkdir(parents=True, exist_ok=True)
        (folder / "status").touch()
        sources = folder / "etc/sources.list"
        sources.write_text("".join(f"deb [signed-by={KEYRING}] {uri} {suite} main\n" for uri, suite in repositories()))
        settings = {"APT::Architecture": arch, "APT::Architectures": arch, "APT::Sandbox::User": "root",
                    "Dir::Etc::SourceList": sources, "Dir::Etc::SourceParts": "-", "Dir::State": folder / "state",
                    "Dir::State::status": folder / "status", "Dir::Cache": folder / "cache", "Acquire::Retries": "3",
                    "Acquire::Languages": "none"}
        self.options = [word for key, value in settings.items() for word in ("-o", f"{key}={value}")]

    def run(self, tool, *words, cwd=None):
        done = subprocess.run([tool, "-qq", *self.options, *words], cwd=cwd, text=True, stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        if done.returncode != 0:
            raise SystemExit(f"error: {tool} {' '.join(words)}: is the network there?\n{done.stdout[-2000:]}")
        return done.stdout

    def download(self, package, folder):
        folder.mkdir(parents=True, exist_ok=True)
        if not list(folder.glob(f"{package}_*.deb")):
            self.run("apt-get", "download", package, cwd=folder)
        return next(folder.glob(f"{package}_*.deb"))


def unpack(deb, folder, wanted=None):
    """All files of a package, or those whose path `wanted` says yes to. Links stay links."""
    with subprocess.Popen(["dpkg-deb", "--fsys-tarfile", str(deb)], stdout=subprocess.PIPE) as pipe:
        with tarfile.open(fileobj=pipe.stdout, mode="r|") as tar:
            for member in tar:
                path = member.name.lstrip("./")
                if path and (member.isfile() or member.issym()) and (wanted is None or wanted(path)):
                    member.name = path
                    tar.extract(member, folder)
    if pipe.returncode != 0:
        raise SystemExit(f"error: {deb} cannot be unpacked; remove it and try again")


def bare_kernel(image):
    """The ELF kernel inside an x86 bzImage: qemu boots it at once, while the image would unpack itself, emulated.

    Source: Documentation/x86/boot.rst (setup_sects at 0x1f1, payload_offset at 0x248, payload_length at 0x24c).
    """
    sectors = image[0x1F1] or 4
    offset, length = struct.unpack_from("<II", image, 0x248)
    begin = (sectors + 1) * 512 + offset
    payload = image[begin:begin + length]
    if not payload.startswith(b"\xfd7zXZ"):
        return None
    return lzma.LZMADecompressor().decompress(payload)


def wanted_of_kernel(path):
    if path.startswith("boot/vmlinuz"):
        return True
    inside = path.split("/kernel/", 1)
    return path.startswith("lib/modules/") and (
        (len(inside) == 2 and inside[1].startswith(MODULE_FOLDERS)) or path.endswith("modules.builtin"))


def prepare(folder, arch, extra_packages=()):
    """Fills folder/arch: kernel, modules/, busybox, root/ (what extra_packages hold). Returns that folder."""
    here = folder / arch
    done = here / f".done-{'-'.join((SUITE, *sorted(extra_packages)))}"
    if done.exists():
        return here
    shutil.rmtree(here / "root", ignore_errors=True)
    apt = Apt(folder / f"apt-{arch}", arch)
    apt.run("apt-get", "update")
    depends = apt.run("apt-cache", "depends", "--important", f"linux-image-{arch}")
    kernel = next(word for word in depends.split() if word.startswith("linux-image-") and word != f"linux-image-{arch}")
    debs = here / "packages"
    unpack(apt.download(kernel, debs), here / "root", wanted_of_kernel)
    unpack(apt.download("busybox-static", debs), here / "root", lambda path: path.endswith("bin/busybox"))
    for package in extra_packages:
        unpack(apt.download(package, debs), here / "root")
    image = next((here / "root/boot").glob("vmlinuz-*")).read_bytes()
    (here / "kernel").write_bytes((bare_kernel(image) if arch == "amd64" else None) or image)
    done.touch()
    return here


def find_busybox(here):
    return next(path for path in (here / "root/bin/busybox", here / "root/usr/bin/busybox") if path.exists())


def find_modules(here):
    return next(pathlib.Path(here / "root/lib/modules").iterdir())
