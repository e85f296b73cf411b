#!/usr/bin/env python3
"""Runs a replay and holds its machine-independent text against the committed one.

usage: golden_replay.py --text FILE --work DIR --recording DIR [--options=A,B,C] [--update] -- COMMAND...
exit code: 0 equal, 1 different or the replay failed, 77 this machine lacks the instruction set (ctest: skipped)

A change of the text is a change of behaviour: run `EGOFOCUS_UPDATE_GOLDEN=1 ctest --test-dir build/release -R golden`,
look at the difference, and explain it in the commit.
"""
import argparse
import os
import pathlib
import shutil
import subprocess
import sys


def first_difference(expected, actual):
    for number, (a, b) in enumerate(zip(expected + [""], actual + [""]), 1):
        if a != b:
            return f"line {number}\n  committed: {a}\n  now:       {b}"
    return f"{len(expected)} lines are committed, now there are {len(actual)}"


def main():
    split = sys.argv.index("--")
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--text", type=pathlib.Path, required=True)
    parser.add_argument("--work", type=pathlib.Path, required=True)
    parser.add_argument("--recording", required=True)
    parser.add_argument("--options", default="")
    arguments = parser.parse_args(sys.argv[1:split])
    command = sys.argv[split + 1:]

    arguments.work.mkdir(parents=True, exist_ok=True)
    text = arguments.work / "golden.txt"
    text.unlink(missing_ok=True)
    options = [option for option in arguments.options.split(",") if option]
    result = subprocess.run(command + ["replay", arguments.recording, "--golden", str(text)] + options,
                            capture_output=True, text=True, check=False)
    if result.returncode == 2 and "this machine has no" in result.stderr:
        print(f"not exercised: {result.stderr.strip()}")
        return 77
    if result.returncode != 0:
        print(f"error: the replay ended with {result.returncode}\n{result.stdout}{result.stderr}")
        return 1
    if os.environ.get("EGOFOCUS_UPDATE_GOLDEN"):
        shutil.copyfile(text, arguments.text)
        print(f"{arguments.text.name} written")
        return 0
    expected = arguments.text.read_bytes()
    actual = text.read_bytes()
    if expected == actual:
        print(f"equal: {arguments.text.name}, {len(actual)} bytes")
        return 0
    print(f"error: {arguments.text.name} differs at " +
          first_difference(expected.decode().split("\n"), actual.decode().split("\n")))
    print(f"the new text is {text}; {__doc__.strip().splitlines()[-2].strip()} {__doc__.strip().splitlines()[-1].strip()}")
    return 1


if __name__ == "__main__":
    sys.exit(main())
