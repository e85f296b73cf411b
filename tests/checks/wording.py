#!/usr/bin/env python3
"""No left-over marks and no paths of one machine in any text file of the project.

usage: wording.py ROOT      exit code 1 when a line breaks the rule
"""
import pathlib
import re
import subprocess
import sys

# Written with brackets so that this file does not find itself.
MARKS = re.compile(r"\b(TO[D]O|FIX[M]E|X[X]X|HA[C]K)\b")
MACHINE_PATHS = re.compile(r"(?<![\w.$}\)/-])/(home|ro[o]t|wo[r]k|Users|mnt|farm|tmp/bash)/")
LONGEST_BYTES = 2_000_000


def files(root):
    """What git knows (ignored files are build outputs); without git, everything outside build folders."""
    listed = subprocess.run(["git", "-C", str(root), "ls-files", "-z", "-co", "--exclude-standard"],
                            capture_output=True, check=False)
    if listed.returncode == 0:
        return [root / name for name in listed.stdout.decode().split("\0") if name]
    return [p for p in root.rglob("*") if p.is_file() and p.relative_to(root).parts[0] not in ("build", "out", ".git")]


def main():
    root = pathlib.Path(sys.argv[1])
    bad = 0
    for path in sorted(files(root)):
        if not path.is_file() or path.stat().st_size > LONGEST_BYTES:
            continue
        data = path.read_bytes()
        if b"\0" in data:
            continue
        for number, line in enumerate(data.decode("utf-8", "replace").splitlines(), 1):
            for rule, what in ((MARKS, "left-over mark"), (MACHINE_PATHS, "path of one machine")):
                found = rule.search(line)
                if found:
                    print(f"error: {path.relative_to(root)}:{number}: {what}: {found.group(0)}")
                    bad += 1
    print(f"wording: {bad} violations")
    return 1 if bad else 0


sys.exit(main())
