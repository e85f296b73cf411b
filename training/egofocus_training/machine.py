"""What the machine is told once, before anything runs."""
import ctypes
import os

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
