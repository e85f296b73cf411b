"""One thread of another process that stands still, as long as a `with` lasts: the others go on."""
import ctypes
import os

_PTRACE_SEIZE, _PTRACE_INTERRUPT, _PTRACE_DETACH = 0x4206, 0x4207, 17
_WALL = 0x40000000

_libc = ctypes.CDLL(None, use_errno=True)
_libc.ptrace.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p]
_libc.ptrace.restype = ctypes.c_long


def _ptrace(request, tid):
    if _libc.ptrace(request, tid, None, None) != 0:
        number = ctypes.get_errno()
        raise OSError(number, "ptrace: " + os.strerror(number))


class HungThread:
    def __init__(self, tid):
        self.tid = tid

    def __enter__(self):
        _ptrace(_PTRACE_SEIZE, self.tid)
        _ptrace(_PTRACE_INTERRUPT, self.tid)
        os.waitpid(self.tid, _WALL)
        return self

    def __exit__(self, *_):
        try:
            _ptrace(_PTRACE_DETACH, self.tid)
        except OSError:
            self.take_leave()  # the process has ended meanwhile

    def take_leave(self):
        """A dead thread that is traced stays until its tracer has looked, and its process with it."""
        try:
            os.waitpid(self.tid, _WALL | os.WNOHANG)
        except ChildProcessError:
            pass
