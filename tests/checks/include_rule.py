#!/usr/bin/env python3
"""Who may include whom: core <- hal, core <- kernels, {core, kernels, hal interfaces} <- pipeline <- everything else.

usage: include_rule.py ROOT      exit code 1 when a line breaks the rule
"""
import pathlib
import re
import sys

# Folder of the including file -> the quoted includes that it may have. "egofocus" is the public API.
ALLOWED = {
    "include/egofocus": {"egofocus"},
    "src/core": {"egofocus", "core"},
    "src/hal": {"egofocus", "core", "hal"},
    "src/kernels": {"egofocus", "core", "kernels"},
    "src/pipeline": {"egofocus", "core", "kernels", "pipeline"},
    "src/recording": {"egofocus", "core", "kernels", "hal", "pipeline", "recording"},
}
HAL_INTERFACES = re.compile(r"hal/\w*source\.hpp$")  # the part of hal that pipeline may see
EIGEN_ONLY_IN = "src/pipeline/eigen.hpp"  # one door, so that Eigen's symbols can be kept out of the library's exports
LIBRARY = ("include/egofocus", "src/core", "src/hal", "src/kernels", "src/pipeline")
# The library may not allocate, throw or print: these headers have nothing to offer it.
BANNED_SYSTEM = re.compile(
    r"^(iostream|fstream|sstream|ostream|istream|iomanip|locale|string|vector|map|set|unordered_\w+|deque|list|memory"
    r"|functional|mutex|condition_variable|thread|future|regex|filesystem|stdexcept|format|cmath|math\.h|random)$")
INCLUDE = re.compile(r'^\s*#\s*include\s*(["<])([^">]+)[">]')


def violations(root):
    for path in sorted(p for top in ("include", "src") for p in (root / top).rglob("*") if p.is_file()):
        if path.suffix not in (".hpp", ".cpp", ".h", ".c", ".inc"):
            continue
        name = path.relative_to(root).as_posix()
        folder = "/".join(name.split("/")[:2])
        if folder not in ALLOWED:
            yield name, 0, "a folder that the include rule does not know: add it to include_rule.py"
            continue
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            found = INCLUDE.match(line)
            if not found:
                continue
            quoted, target = found.group(1) == '"', found.group(2)
            if target.startswith("Eigen/") or target.startswith("unsupported/Eigen"):
                if name != EIGEN_ONLY_IN:
                    yield name, number, f"Eigen is included by {EIGEN_ONLY_IN} alone"
            elif quoted and not (target.split("/")[0] in ALLOWED[folder] and "/" in target):
                if not (folder == "src/pipeline" and HAL_INTERFACES.match(target)):
                    yield name, number, f'{folder} must not include "{target}"'
            elif not quoted and target.split("/")[0] in ("egofocus", "core", "hal", "kernels", "pipeline"):
                yield name, number, f"our own headers are included in quotes: <{target}>"
            elif not quoted and folder in LIBRARY and BANNED_SYSTEM.match(target):
                yield name, number, f"<{target}> has no place in the library: no heap, no exceptions, no libm, no output"


def main():
    bad = 0
    for name, number, what in violations(pathlib.Path(sys.argv[1])):
        print(f"error: {name}:{number}: {what}")
        bad += 1
    print(f"include rule: {bad} violations")
    return 1 if bad else 0


sys.exit(main())
