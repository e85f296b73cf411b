#!/usr/bin/env python3
"""Every fault that a robot may meet, done to the real code: what was lost, and how long until depth is good again.

usage: fault_matrix.py BUILD [--json FILE] [--write DOCUMENT] [--processes] [--only NAME ...]

BUILD is a build folder, such as build/release. Prints the table; --write puts it between the markers of a document.
Exit code 1 when a fault did what none may: crash, hang, lose uncounted, leave a poor frame without a flag, take memory.
"""
import argparse
import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests/egofocusd"), str(ROOT / "tests/reliability")]
import daemon_process  # noqa: E402
import process_faults  # noqa: E402

BEGIN, END = "<!-- fault matrix: begin -->", "<!-- fault matrix: end -->"
FLAGS = ("no parallax", "too few events", "stale velocity", "no motion", "overload", "late tick", "carried")


def scripted_rows(build):
    done = subprocess.run([str(build / "tests/reliability/scripted_faults")], capture_output=True, text=True, check=False,
                          timeout=900)
    rows = [json.loads(line) for line in done.stdout.splitlines()]
    if not rows or done.returncode not in (0, 1) or (done.returncode == 1) != any(row["complaints"] for row in rows):
        raise SystemExit(f"scripted_faults ended with {done.returncode} after {len(rows)} faults: {done.stderr}")
    return rows


def of_processes(build, names):
    daemon_process.arguments = argparse.Namespace(
        daemon=str(build / "apps/egofocusd/egofocusd"), app=str(build / "apps/egofocus/egofocus"),
        recording=str(ROOT / "fixtures/planes"), source=str(ROOT), cc="cc")
    return process_faults.rows(names)


def flag_names(flags):
    return ", ".join(name for bit, name in enumerate(FLAGS) if flags >> bit & 1) or "none"


def lost_text(row):
    parts = [f"{name} {count:,}" for name, count in row["lost"].items()]
    return ", ".join(parts) or "nothing"


def table(rows):
    lines = ["| fault | how it was made | lost, as counted | depth good after | RSS | flags meanwhile | remark |",
             "|---|---|---|---|---|---|---|"]
    for row in rows:
        good = "" if row["good_after_s"] is None else f"{row['good_after_s']:.2f} s"
        memory = "" if row["rss_percent"] is None else f"{row['rss_percent']:+.2f} %"
        lines.append("| " + " | ".join([row["fault"], row["made"], lost_text(row), good, memory, flag_names(row["flags"]),
                                        row["remark"]]).replace("\n", " ") + " |")
    return "\n".join(lines)


def write(document, text):
    before = document.read_text(encoding="utf-8")
    begin, end = before.index(BEGIN) + len(BEGIN), before.index(END)
    document.write_text(before[:begin] + "\n" + text + "\n" + before[end:], encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("--write", type=pathlib.Path)
    parser.add_argument("--processes", action="store_true", help="leave out what scripted devices do")
    parser.add_argument("--only", nargs="*", default=(), help="names of functions in process_faults.py")
    given = parser.parse_args()
    build = given.build.resolve()
    rows = [] if given.only or given.processes else scripted_rows(build)
    for row in of_processes(build, given.only):
        print(f"{row['fault']}: {row['complaints'] or 'as it must be'}", flush=True)
        rows.append(row)
    print(table(rows))
    failures = [row for row in rows if row["complaints"]]
    for row in failures:
        print(f"error: {row['fault']}: {row['complaints']}")
    print(f"{len(rows)} faults, {len(failures)} not as they must be")
    if given.json:
        given.json.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    if given.write and not failures:
        write(given.write, table(rows))
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
