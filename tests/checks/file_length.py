#!/usr/bin/env python3
"""No C or C++ file above 400 lines; above 300 it is named. Long files hold more than two ideas.

usage: file_length.py ROOT      exit code 1 when a file is too long
"""
import pathlib
import sys

WARN_LINES, FAIL_LINES = 300, 400
FOLDERS = ("include", "src", "apps", "tests", "bench", "tools", "training")
SUFFIXES = (".hpp", ".cpp", ".h", ".c", ".inc")


def main():
    root = pathlib.Path(sys.argv[1])
    bad = 0
    for path in sorted(p for folder in FOLDERS for p in (root / folder).rglob("*") if p.suffix in SUFFIXES):
        lines = len(path.read_text(encoding="utf-8").splitlines())
        name = path.relative_to(root)
        if lines > FAIL_LINES:
            print(f"error: {name}: {lines} lines, {FAIL_LINES} are the limit: split it by its ideas")
            bad += 1
        elif lines > WARN_LINES:
            print(f"note: {name}: {lines} lines; about {WARN_LINES} are meant")
    print(f"file length: {bad} violations")
    return 1 if bad else 0


sys.exit(main())
