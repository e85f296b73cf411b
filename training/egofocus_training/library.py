"""The library's own front end (training/binding), wherever it was built."""
import importlib
import pathlib
import sys

from .errors import FILE, TrainingError

_BUILT = pathlib.Path(__file__).resolve().parents[2] / "build" / "training" / "training"


class _Missing:
    def __getattr__(self, name):
        raise TrainingError(FILE, "egofocus_stack", "is not built. Run: cmake --preset training && "
                            "cmake --build build/training --target egofocus_stack")


def _load():
    for path in (None, str(_BUILT)):
        if path is not None and path not in sys.path:
            sys.path.append(path)
        try:
            return importlib.import_module("egofocus_stack")
        except ModuleNotFoundError:
            continue
    return _Missing()


stack = _load()
