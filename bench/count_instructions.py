#!/usr/bin/env python3
"""Instructions a multiply-add of each ARM body of conv_u8s8 and depthwise_u8s8, executed under qemu-user with its counting plugin.

usage: bench/count_instructions.py [--layers compared|base|small|all] [--compiler g++|clang] [--json FILE]
       bench/count_instructions.py --tick RECORDING MODEL [--threads N] [--json FILE]

Counted are warm calls, with the leaving of sums (requantisation) and everything else inside: the difference of one and
of two calls. Each body is compiled by g++ and, where there is one, by clang (the presets aarch64 and aarch64-clang).
--tick counts `egofocus replay --backend network` on one thread instead, by function: the difference of 4 and of 12 ticks,
on a processor with SDOT and on one without, but for what the command line itself does. bench/model_loops.py makes times of it.
--threads 2 tells instead how evenly the functions of a tick are spread over the threads, whatever else the machine does.

Exit status: 0 done, 3 a tool is missing (the message names it).
"""
import argparse
import collections
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
SYSROOT = "/usr/aarch64-linux-gnu"
BODIES = ("neondot", "neonmm", "neon")
# All that conv_u8s8 compiles to: blocks_of, conv_*, leave_*.
CONVOLUTION = re.compile(r"9blocks_of|_1\d+conv_|leave_as|conv_u8s8")
# The command line around a tick, which is compiled without optimisation: hashes of frames, counts for its report.
COMMAND_LINE = re.compile(r"^_ZZ?N?K?(8egofocus3app|9__gnu_cxx|St)")
# The pool itself: how long a thread waits is the machine's, not the tick's.
WAITING = re.compile(r"10WorkerPool(10wait_while|4wake|4work|3run)|^pthread|^sched|futex|^syscall")
COMPARED = ("3x3_32_32", "3x3_64_64", "1x1_64_64", "3x3s2_32_64", "3x3x3_8_8", "depthwise_48")
# XNNPACK and ncnn, counted in the same way (warm, requantisation included, the better of two compilers) on the same shapes.
PEERS = {
    "neondot": {"XNNPACK": (.095, .086, .110, .094, .211, .800), "ncnn": (.109, .091, .122, .097, None, .603)},
    "neonmm": {"XNNPACK": (.069, .057, .089, .068, .170, .800), "ncnn": (.075, .059, .093, .065, None, .603)},
    "neon": {"XNNPACK": (.289, .272, .317, .288, .324, .800), "ncnn": (.270, .254, .295, .261, None, .603)},
}
GOALS = {"neondot": (.081, .080, .105, .082, .087, .36), "neonmm": (.051, .050, .080, .059, .056, .36),
         "neon": (.25, .25, .28, .25, .28, .50)}


def missing(what, package):
    print(f"error: {what} was not found; on Debian: apt-get install {package}", file=sys.stderr)
    sys.exit(3)


def run(command, **options):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, **options)
    if done.returncode != 0:
        print((done.stdout + done.stderr)[-3000:], file=sys.stderr)
        sys.exit(f"error: {' '.join(str(word) for word in command)} failed with {done.returncode}")
    return done.stdout


def compilers():
    """Name -> preset."""
    for tool, package in (("qemu-aarch64", "qemu-user"), ("aarch64-linux-gnu-g++", "g++-aarch64-linux-gnu"),
                          ("cc", "gcc"), ("cmake", "cmake"), ("ninja", "ninja-build")):
        if shutil.which(tool) is None:
            missing(tool, package)
    if shutil.which("clang++-19") or shutil.which("clang++"):
        return {"g++": "aarch64", "clang": "aarch64-clang"}
    print("note: no clang++: g++ alone (apt-get install clang-19)")
    return {"g++": "aarch64"}


def build(preset, target):
    run(["cmake", "--preset", preset, "-DEGOFOCUS_BUILD_BENCH=ON"], cwd=ROOT)
    run(["cmake", "--build", ROOT / "build" / preset, "--target", target])
    return ROOT / "build" / preset


class Counter:
    def __init__(self, folder):
        self.plugin = folder / "count_instructions_plugin.so"
        self.counts = folder / f"counts_{os.getpid()}.txt"
        run(["cc", "-O2", "-shared", "-fPIC", "-o", self.plugin, ROOT / "bench/count_instructions_plugin.c"])

    def by_function(self, *command, cpu="max"):
        self.counts.unlink(missing_ok=True)
        run(["qemu-aarch64", "-cpu", cpu, "-L", SYSROOT, "-plugin", f"{self.plugin},out={self.counts}", *command])
        if not self.counts.exists():
            missing("a qemu-aarch64 that loads plugins (QEMU 4.2 to 8)", "qemu-user")
        pairs = (line.split(maxsplit=1) for line in self.counts.read_text().splitlines())
        counted = collections.Counter({name: int(count) for count, name in pairs})
        self.counts.unlink()
        return counted

    def by_thread(self, *command, cpu="max"):
        """function -> [instructions of each thread]"""
        self.counts.unlink(missing_ok=True)
        run(["qemu-aarch64", "-cpu", cpu, "-L", SYSROOT, "-plugin", f"{self.plugin},out={self.counts},threads=on", *command])
        counted = collections.defaultdict(lambda: [0] * 8)
        for line in self.counts.read_text().splitlines():
            count, thread, name = line.split(maxsplit=2)
            counted[name][int(thread)] += int(count)
        self.counts.unlink()
        return counted

    def all(self, *command):
        return sum(self.by_function(*command).values())


def count_layers(counter, program, wanted):
    """(body, layer) -> (instructions of a call, multiply-adds of a call, times in a tick, whose layer it is)"""
    listed = run(["qemu-aarch64", "-cpu", "max", "-L", SYSROOT, program])
    counted = {}
    for body, layer, multiply_adds, times, of in (line.split() for line in listed.splitlines()):
        if body in BODIES and wanted in ("all", of):
            calls = [counter.all(program, body, layer, n) for n in (1, 2)]
            counted[body, layer] = (calls[1] - calls[0], float(multiply_adds), int(times), of)
    for body, layer in list(counted):
        if body == "neondot":
            counted.setdefault(("neonmm", layer), counted[body, layer])  # no body of its own: this one runs
    return counted


def print_compared(results):
    print("\ninstructions a multiply-add".ljust(29) + "".join(f"{name:>14}" for name in COMPARED))
    for body in BODIES:
        for compiler, counted in results.items():
            ours = [counted[body, layer][0] / counted[body, layer][1] for layer in COMPARED]
            print(f"{body} {compiler}".ljust(28) + "".join(f"{value:14.4f}" for value in ours))
        for peer, values in PEERS[body].items():
            print(f"  {peer}".ljust(28) + "".join("none".rjust(14) if value is None else f"{value:14.3f}" for value in values))
        print("  goal".ljust(28) + "".join(f"{value:14.3f}" for value in GOALS[body]))


def print_model(results, model):
    columns = [(body, compiler) for body in BODIES for compiler in results]
    print(f"\nlayers of `{model}`, instructions a multiply-add".ljust(47) + "".join(f"{b + ' ' + c:>15}" for b, c in columns))
    layers = [layer for (body, layer), (*_, of) in next(iter(results.values())).items() if body == BODIES[0] and of == model]
    for layer in layers:
        values = (results[c][b, layer][0] / results[c][b, layer][1] for b, c in columns)
        print(layer.ljust(46) + "".join(f"{value:15.4f}" for value in values))
    sums = {}
    for body, compiler in columns:
        rows = [results[compiler][body, layer] for layer in layers]
        sums[body, compiler] = sum(count * times for count, _, times, _ in rows)
    print("all of a tick, million instructions".ljust(46) + "".join(f"{sums[key] / 1e6:15.1f}" for key in columns))


def replay(program, recording, model, threads, ticks):
    return (program, "replay", recording, "--backend", "network", "--model", model, "--threads", str(threads), "--ticks", str(ticks))


def print_threads(counter, program, recording, model, threads):
    """Of a tick's functions: what the busiest thread runs of each. Their sum is a bound of what more threads can bring; returned."""
    short, longer = (counter.by_thread(*replay(program, recording, model, threads, ticks), cpu="cortex-a76") for ticks in (4, 12))
    each = {name: [(b - a) / 8 for a, b in zip(short.get(name, [0] * 8), counts)] for name, counts in longer.items()
            if not COMMAND_LINE.search(name) and not WAITING.search(name)}
    everything, longest = sum(map(sum, each.values())), sum(map(max, each.values()))
    by_thread = [sum(counts[t] for counts in each.values()) / 1e6 for t in range(threads)]
    print("\nmillion instructions a tick by thread: " + "  ".join(f"{count:.1f}" for count in by_thread) +
          f"\nall / the busiest thread's of each function: {everything / longest:.3f}\n"
          "million instructions by which the busiest thread has more than its share:")
    excess = {name: max(counts) - sum(counts) / threads for name, counts in each.items()}
    for name, count in sorted(excess.items(), key=lambda item: -item[1])[:10]:
        print(f"{count / 1e6:10.3f} of {sum(each[name]) / 1e6:7.2f}  {name}")
    return {"threads": threads, "gain": everything / longest}


def count_tick(counter, program, recording, model):
    """Body -> instructions of a tick: those of the convolutions, and the rest by function."""
    counted = {}
    for body, cpu in (("neondot", "cortex-a76"), ("neon", "cortex-a72")):
        short, longer = (counter.by_function(*replay(program, recording, model, 1, ticks), cpu=cpu) for ticks in (4, 12))
        each = {name: (count - short[name]) / 8 for name, count in longer.items()
                if count != short[name] and not COMMAND_LINE.search(name)}
        convolutions = sum(count for name, count in each.items() if CONVOLUTION.search(name))
        rest = {name: count for name, count in each.items() if not CONVOLUTION.search(name)}
        counted[body] = {"convolutions": convolutions, "rest": sum(rest.values()), "rest_by_function": rest}
    return counted


def print_tick(counted):
    for body, tick in counted.items():
        print(f"\n{body}: million instructions a tick: convolutions {tick['convolutions'] / 1e6:.1f}, rest {tick['rest'] / 1e6:.1f}, of it")
        for name, count in sorted(tick["rest_by_function"].items(), key=lambda item: -item[1])[:12]:
            print(f"{count / 1e6:10.2f}  {name}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--layers", choices=("compared", "base", "small", "all"), default="all")
    parser.add_argument("--compiler", choices=("g++", "clang"), help="one of them alone")
    parser.add_argument("--tick", nargs=2, metavar=("RECORDING", "MODEL"))
    parser.add_argument("--threads", type=int, default=1, metavar="N")
    parser.add_argument("--json", type=pathlib.Path)
    arguments = parser.parse_args()
    found = compilers()
    if arguments.tick:
        folder = build("aarch64", "egofocus_app")
        if arguments.threads > 1:
            tick = print_threads(Counter(folder), folder / "apps/egofocus/egofocus", *arguments.tick, arguments.threads)
        else:
            tick = count_tick(Counter(folder), folder / "apps/egofocus/egofocus", *arguments.tick)
            print_tick(tick)
        if arguments.json:
            arguments.json.write_text(json.dumps(tick, indent=1) + "\n")
        return
    results = {}
    for name, preset in found.items():
        if arguments.compiler not in (None, name):
            continue
        folder = build(preset, "run_conv")
        results[name] = count_layers(Counter(folder), folder / "bench/run_conv", arguments.layers)
    if arguments.layers in ("compared", "all"):
        print_compared(results)
    for model in ("base", "small"):
        if arguments.layers in (model, "all"):
            print_model(results, model)
    if arguments.json:
        rows = [{"compiler": compiler, "body": body, "layer": layer, "instructions": count,
                 "multiply_adds": multiply_adds, "times_in_a_tick": times}
                for compiler, counted in results.items() for (body, layer), (count, multiply_adds, times, _) in counted.items()]
        arguments.json.write_text(json.dumps({"counted": rows, "peers": PEERS, "goals": GOALS}, indent=1) + "\n")


main()
