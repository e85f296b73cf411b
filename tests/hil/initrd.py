"""The guest's whole file system as one archive: init, busybox, kernel modules, programs and the libraries they need."""
import os
import pathlib
import re
import stat
import subprocess

TRIPLETS = {"amd64": "x86_64-linux-gnu", "arm64": "aarch64-linux-gnu"}
LOADERS = {"amd64": "lib64/ld-linux-x86-64.so.2", "arm64": "lib/ld-linux-aarch64.so.1"}
ALWAYS = ("virtio_pci", "virtio_console")  # the way out for output


class Archive:
    """cpio, "newc" form (Documentation/driver-api/early-userspace/buffer-format.rst), uncompressed: unpacking in an
    emulated processor costs more than reading."""

    def __init__(self):
        self.parts = []
        self.known = set()

    def _entry(self, name, mode, data):
        if name in self.known:
            return
        self.known.add(name)
        path = name.encode() + b"\0"
        fields = (len(self.known), mode, 0, 0, 1, 0, len(data), 0, 0, 0, 0, len(path), 0)
        head = b"070701" + b"".join(b"%08X" % field for field in fields) + path
        self.parts += [head + b"\0" * (-len(head) % 4), data + b"\0" * (-len(data) % 4)]

    def folder(self, name):
        if name and name not in self.known:
            self.folder(os.path.dirname(name))
            self._entry(name, stat.S_IFDIR | 0o755, b"")

    def file(self, name, data, executable=False):
        self.folder(os.path.dirname(name))
        self._entry(name, stat.S_IFREG | (0o755 if executable else 0o644), data)

    def link(self, name, target):
        self.folder(os.path.dirname(name))
        self._entry(name, stat.S_IFLNK | 0o777, target.encode())

    def bytes(self):
        self._entry("TRAILER!!!", 0, b"")
        return b"".join(self.parts)


def plain_name(module):
    return pathlib.Path(module).name.split(".ko")[0].replace("-", "_")


class Modules:
    """Kernel modules by name, with what each depends on: read from the modules themselves, as depmod does."""

    def __init__(self, folder):
        self.folder = folder
        self.paths = {plain_name(path): path for path in folder.rglob("*.ko")}
        builtin = (folder / "modules.builtin").read_text().split()
        self.builtin = {plain_name(path) for path in builtin}
        self.needs = {}

    def depends(self, name):
        if name not in self.needs:
            found = re.search(rb"\0depends=([^\0]*)\0", self.paths[name].read_bytes())
            words = found.group(1).decode().split(",") if found else []
            self.needs[name] = [word.replace("-", "_") for word in words if word]
        return self.needs[name]

    def closure(self, name, into):
        """Adds a module after all that it needs."""
        name = name.replace("-", "_")
        if name in into or (name in self.builtin and name not in self.paths):
            return
        if name not in self.paths:
            raise SystemExit(f"error: the guest's kernel has no module {name}")
        for other in self.depends(name):
            self.closure(other, into)
        into.append(name)

    def add_to(self, archive, names):
        release = self.folder.name
        lines = []
        chosen = []
        for name in (*ALWAYS, *names):
            self.closure(name, chosen)
        for name in chosen:
            inside = self.paths[name].relative_to(self.folder).as_posix()
            archive.file(f"lib/modules/{release}/{inside}", self.paths[name].read_bytes())
            own = []
            self.closure(name, own)
            # modprobe loads from the end.
            others = " ".join(self.paths[other].relative_to(self.folder).as_posix() for other in reversed(own[:-1]))
            lines.append(f"{inside}: {others}".rstrip())
        archive.file(f"lib/modules/{release}/modules.dep", ("\n".join(lines) + "\n").encode())


def add_libraries(archive, arch, programs, extra_root):
    """The loader and all shared libraries that the programs need."""
    triplet = TRIPLETS[arch]
    folders = [extra_root / "lib" / triplet, extra_root / "usr/lib" / triplet, pathlib.Path(f"/usr/{triplet}/lib"),
               pathlib.Path(f"/lib/{triplet}"), pathlib.Path(f"/usr/lib/{triplet}")]
    waiting = list(programs)
    seen = set()

    def add(name):
        for folder in folders:
            if (folder / name).exists():
                archive.file(f"lib/{triplet}/{name}", (folder / name).resolve().read_bytes(), True)
                waiting.append(folder / name)
                return (folder / name).resolve().read_bytes()
        raise SystemExit(f"error: library {name} for {arch} not found in {', '.join(map(str, folders))}")

    while waiting:
        said = subprocess.run(["readelf", "-d", str(waiting.pop())], capture_output=True, text=True).stdout
        for name in re.findall(r"\(NEEDED\).*\[(.*)\]", said):
            if name not in seen:
                seen.add(name)
                add(name)
    if seen:
        loader = LOADERS[arch]
        archive.file(loader, add(os.path.basename(loader)), True)
