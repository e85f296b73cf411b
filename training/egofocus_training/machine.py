"""What the machine is told once, before anything runs."""
import ctypes
import fcntl
import os

from .errors import FILE, USAGE, TrainingError

_M_TRIM_THRESHOLD, _M_MMAP_THRESHOLD = -1, -3  # glibc's mallopt
_LARGEST_MMAP_THRESHOLD = 32 << 20


def keep_freed_memory():
    """Freed tensors stay with the process: handing pages back and faulting them in again costs a tenth of the time."""
    try:
        mallopt = ctypes.CDLL(None).mallopt
    except AttributeError:
        return  # another C library
    mallopt(_M_MMAP_THRESHOLD, _LARGEST_MMAP_THRESHOLD)
    mallopt(_M_TRIM_THRESHOLD, 2_000_000_000)


def free_bytes(path):
    """Bytes that the disk under `path` has left."""
    disk = os.statvfs(path)
    return disk.f_bavail * disk.f_frsize


def only_run(folder):
    """Keeps other processes out of a training's folder as long as this one lives; what it returns is to be kept."""
    try:
        file = open(folder / "lock", "a", encoding="utf-8")
    except OSError as error:
        raise TrainingError(FILE, folder, f"cannot be written ({error.strerror}).") from None
    try:
        fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        file.close()
        raise TrainingError(USAGE, folder, "another process trains there. Wait for its checkpoint, or name another.") from None
    return file
