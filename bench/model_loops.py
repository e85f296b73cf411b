#!/usr/bin/env python3
"""Inner loops by their object code: cycles that llvm-mca models for ARM cores, and instructions.

usage: bench/model_loops.py [--tick FILE [--threads FILE]]
       bench/model_loops.py --count OBJDUMP OBJECT...

The first form takes the bodies of conv_u8s8 that bench/count_instructions.py compiled with g++, finds in each the loop with
the most multiplications for an instruction, and prints its share of the multiplier's peak on each core; operands in the first cache are
assumed, as llvm-mca does. --tick FILE, of `count_instructions.py --tick --json FILE`, projects the time of a tick; --threads FILE, of
the same with --threads N, that on N cores, of which none waits for memory or to be woken.
The second form counts the longest loop of each requantisation candidate: one straight loop each.

Exit status: 0 done, 3 a tool or an object is missing (the message names it).
"""
import argparse
import json
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
LINE = re.compile(r"^\s*([0-9a-f]+):\s+(\S+)\s*(.*)$")
JUMP = re.compile(r"^(j[a-z]+|b\.?[a-z]{2}(\.n|\.w)?|cbn?z|tbn?z)$")
MULTIPLY_ADDS = {"sdot": 16, "smmla": 32, "smull": 8, "smull2": 8, "smlal": 8, "smlal2": 8}

# Core -> its model in llvm-mca, the body that runs on it, multiply-adds a cycle at most (two 128-bit SDOT; one, in two
# halves; one 64-bit multiplication), the goal.
CORES = {
    "Cortex-A76": ("neoverse-n1", "neondot", 32, 0.90),
    "Cortex-A55": ("cortex-a55", "neondot", 16, 0.60),
    "Cortex-A72": ("cortex-a72", "neon", 8, 0.90),
}
TILES = {"neondot": "TileILi5ELi4", "neon": "TileILi2ELi2"}  # the widest one, of layers with 16 and more outputs
# Board, core, clock, instructions a cycle of all that is no convolution (assumed).
BOARDS = (
    ("Raspberry Pi 5", "Cortex-A76", 2.4, 1.5),
    ("Raspberry Pi 4", "Cortex-A72", 1.5, 1.0),
    ("Raspberry Pi 4", "Cortex-A72", 1.8, 1.0),
    ("Cortex-A55 board", "Cortex-A55", 1.8, 0.6),
    ("Cortex-A55 board", "Cortex-A55", 2.0, 0.6),
)


def functions(objdump, path):
    text = subprocess.run([objdump, "-d", "--no-show-raw-insn", path], check=True, capture_output=True, text=True).stdout
    name, body = None, []
    for line in text.splitlines():
        head = re.match(r"^[0-9a-f]+ <(.+)>:$", line)
        if head:
            if name:
                yield name, body
            name, body = head.group(1), []
        else:
            found = LINE.match(line)
            if found:
                body.append((int(found.group(1), 16), found.group(2), found.group(3)))
    if name:
        yield name, body


def loops(body):
    """Each backward jump ends a loop, its target begins it."""
    for at, (address, mnemonic, operands) in enumerate(body):
        target = re.search(r"\b([0-9a-f]+) <", operands)
        if JUMP.match(mnemonic) and target and int(target.group(1), 16) < address:
            start = int(target.group(1), 16)
            yield [line for line in body[: at + 1] if line[0] >= start]


def count_candidates(objdump, paths):
    for path in paths:
        for name, body in functions(objdump, path):
            if not name.startswith("requant_"):
                continue
            elements = 32 if "avx2" in name else 16
            count = max((len(loop) for loop in loops(body)), default=0)
            print(f"{name:28s} {count:4d} instructions / {elements} elements = {count / elements:.2f}")


def multiply_adds(loop):
    return sum(MULTIPLY_ADDS.get(mnemonic, 0) for _, mnemonic, _ in loop)


def hottest_loop(objdump, path, symbol):
    """Of the innermost loops of one function the one with the most multiplications for an instruction."""
    innermost = []
    for name, body in functions(objdump, path):
        if symbol not in name:
            continue
        found = list(loops(body))
        innermost += [loop for loop in found if not any(other[0][0] >= loop[0][0] and other[-1][0] < loop[-1][0]
                                                        for other in found)]
    return max(innermost, key=lambda loop: multiply_adds(loop) / len(loop))


def cycles(mca, cpu, loop):
    """Of one turn: 100 of them, modelled one after the other."""
    text = "loop:\n" + "\n".join(f"{mnemonic} {re.sub(r'[0-9a-f]+ <.*', 'loop', operands.split('//')[0])}"
                                 for _, mnemonic, operands in loop)
    out = subprocess.run([mca, "-mtriple=aarch64", f"-mcpu={cpu}", "-mattr=+dotprod,+i8mm", "-iterations=100"], input=text,
                         capture_output=True, text=True)
    found = re.search(r"Total Cycles:\s+(\d+)", out.stdout)
    if not found:
        sys.exit(f"error: llvm-mca: {out.stderr[:1000]}")
    return int(found.group(1)) / 100


def object_of(build, body):
    path = build / f"CMakeFiles/egofocus.dir/src/kernels/conv_u8s8_{body}.cpp.o"
    if not path.exists():
        print(f"error: {path} was not found; run bench/count_instructions.py first", file=sys.stderr)
        sys.exit(3)
    return path


def model(mca, build):
    """Core -> modelled instructions a cycle of the convolution's loop."""
    rate = {}
    print(f"{'core':14}{'body':10}{'instructions':>13}{'cycles':>9}{'multiply-adds':>15}{'a cycle':>9}{'of peak':>9}{'goal':>7}")
    for core, (cpu, body, peak, goal) in CORES.items():
        loop = hottest_loop("aarch64-linux-gnu-objdump", object_of(build, body), TILES[body])
        taken = cycles(mca, cpu, loop)
        done = multiply_adds(loop) / taken
        rate[core] = len(loop) / taken
        print(f"{core:14}{body:10}{len(loop):13d}{taken:9.1f}{multiply_adds(loop):15d}{done:9.2f}{done / peak:9.1%}{goal:7.0%}")
    return rate


def project(rate, tick, spread):
    several = f"{spread['threads']} cores".rjust(12) if spread else ""
    print(f"\n{'board':18}{'core':12}{'GHz':>5}{'convolutions':>14}{'rest':>8}{'IPC of rest':>13}{'tick':>10}{'rate':>9}{several}")
    for board, core, clock_ghz, rest_rate in BOARDS:
        counted = tick["neon" if core == "Cortex-A72" else "neondot"]
        convolutions_ms = counted["convolutions"] / rate[core] / clock_ghz / 1e6
        rest_ms = counted["rest"] / rest_rate / clock_ghz / 1e6
        whole_ms = convolutions_ms + rest_ms
        print(f"{board:18}{core:12}{clock_ghz:5.1f}{convolutions_ms:11.1f} ms{rest_ms:5.1f} ms{rest_rate:13.1f}"
              f"{whole_ms:7.1f} ms{1000 / whole_ms:6.1f} Hz" + (f"{1000 / whole_ms * spread['gain']:9.1f} Hz" if spread else ""))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/aarch64")
    parser.add_argument("--tick", type=pathlib.Path)
    parser.add_argument("--threads", type=pathlib.Path)
    parser.add_argument("--count", nargs="+")
    arguments = parser.parse_args()
    if arguments.count:
        return count_candidates(arguments.count[0], arguments.count[1:])
    mca = next((found for found in map(shutil.which, ("llvm-mca-19", "llvm-mca")) if found), None)
    for tool, package in ((mca, "llvm-19"), (shutil.which("aarch64-linux-gnu-objdump"), "binutils-aarch64-linux-gnu")):
        if tool is None:
            print(f"error: a tool was not found; on Debian: apt-get install {package}", file=sys.stderr)
            sys.exit(3)
    rate = model(mca, arguments.build)
    if arguments.tick:
        project(rate, json.loads(arguments.tick.read_text()), json.loads(arguments.threads.read_text()) if arguments.threads else None)


main()
