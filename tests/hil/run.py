#!/usr/bin/env python3
"""Runs the tests of this folder on real kernels, in emulated guests. README.md says how to add one.

usage: run.py [--arch amd64|arm64] [--keep-output] [--patience N] [--prepare] [NAME ...]     from the root of the tree; exit code 1 when a
test fails
"""
import argparse
import pathlib
import re
import shlex
import sys
import time

import guest
import guest_system

HERE = pathlib.Path(__file__).parent
PRESETS = {"amd64": "release", "arm64": "aarch64-hil"}
WORK = pathlib.Path("build/hil")
PACKAGES = (HERE / "guest_packages.txt").read_text().split()


def header(script, key):
    """The words of the lines `# key: words` of a test."""
    return " ".join(re.findall(rf"^# {key}: (.*)$", script, re.M))


def program_named(name, arch):
    folder = pathlib.Path("build") / PRESETS[arch]
    for path in (folder / "tests/hil" / name, *folder.glob(f"apps/*/{name}")):
        if path.is_file():
            return path
    raise SystemExit(f"error: {name} is not in {folder}: cmake --build {folder} --target hil_programs")


def run_test(path, arch, system, show, patience):
    script = path.read_text()
    programs = [program_named(name, arch) for name in header(script, "programs").split()]
    files = {pathlib.Path(name).name: pathlib.Path(name).read_bytes() for name in header(script, "files").split()}
    initrd = guest.pack(system, arch, script, programs, header(script, "modules").split(), files)
    begin = time.monotonic()
    code, output, kernel_log = guest.run(system, arch, initrd, patience * int(header(script, "limit") or 180),
                                         header(script, "clock") or "host", shlex.split(header(script, "qemu")))
    seconds = time.monotonic() - begin
    oops = re.search(r"^.*(BUG:|Oops|Call Trace|Kernel panic).*$", kernel_log, re.M)
    passed = code == 0 and not oops
    print(f"{'ok    ' if passed else 'FAILED'} {arch} {path.stem:24} {seconds:5.1f} s", flush=True)
    if not passed or show:
        print(f"exit code {code}\n{output}\n--- kernel\n{kernel_log[-3000:]}", flush=True)
    return passed


def main():
    parser = argparse.ArgumentParser(description="Tests on real kernels in emulated guests.")
    parser.add_argument("names", nargs="*", help="tests, without .sh; all when none is named")
    parser.add_argument("--arch", choices=guest_system.ARCHES, action="append")
    parser.add_argument("--keep-output", action="store_true", help="print what passing tests say as well")
    parser.add_argument("--patience", type=int, default=1, metavar="N", help="limits N times as long")
    parser.add_argument("--prepare", action="store_true", help="only fetch what guests are made of")
    asked = parser.parse_args()
    arches = asked.arch or guest_system.ARCHES
    systems = {arch: guest_system.prepare(WORK, arch, PACKAGES) for arch in arches}
    if asked.prepare:
        return 0
    tests = sorted(path for path in HERE.glob("*_test.sh") if not asked.names or path.stem in asked.names)
    if not tests or len(tests) < len(set(asked.names)):
        raise SystemExit(f"error: no such test; there are: {' '.join(sorted(p.stem for p in HERE.glob('*_test.sh')))}")
    passed = failed = 0
    for arch in arches:
        for path in tests:
            if run_test(path, arch, systems[arch], asked.keep_output, asked.patience):
                passed += 1
            else:
                failed += 1
    percent = 100 * passed // (passed + failed)
    print(f"{percent}% tests passed, {failed} tests failed out of {passed + failed}")
    return 1 if failed else 0


sys.exit(main())
