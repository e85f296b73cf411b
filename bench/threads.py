#!/usr/bin/env python3
"""What a second thread brings: whole ticks with one and with several, in turns.

usage: bench/threads.py EGOFOCUS RECORDING MODEL [--threads N] [--turns N]

Each turn runs `EGOFOCUS replay RECORDING --backend network --model MODEL` on one thread and on N, in random order; a run's figure
is the median time of its ticks. Printed: the medians over turns, their ratio, and in brackets the middle 95 % of 1,000 bootstrap
draws of turns. The machine must have N processors to spare: a thread that waits for one delays the others. Where it has
not, bench/count_instructions.py --tick ... --threads N counts how even the shares are.

Exit status: 0 done, 3 the replay failed (its message stands above).
"""
import argparse
import json
import random
import statistics
import subprocess
import sys

RESAMPLES = 1000


def tick_ms(command, threads):
    done = subprocess.run([*command, "--threads", str(threads), "--json"], capture_output=True, text=True)
    if done.returncode != 0:
        print(done.stdout + done.stderr, file=sys.stderr)
        sys.exit(3)
    return json.loads(done.stdout)["tick_ms"]["p50"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", metavar="EGOFOCUS")
    parser.add_argument("recording")
    parser.add_argument("model")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--turns", type=int, default=20)
    arguments = parser.parse_args()
    command = [arguments.program, "replay", arguments.recording, "--backend", "network", "--model", arguments.model]
    generator = random.Random(1)
    times = {1: [], arguments.threads: []}
    for _ in range(arguments.turns):
        for threads in generator.sample(list(times), 2):
            times[threads].append(tick_ms(command, threads))

    def ratio(turns):
        return statistics.median(times[1][t] for t in turns) / statistics.median(times[arguments.threads][t] for t in turns)

    turns = range(arguments.turns)
    draws = sorted(ratio(generator.choices(turns, k=len(turns))) for _ in range(RESAMPLES))
    for threads, taken in times.items():
        print(f"{threads} threads: {statistics.median(taken):7.2f} ms a tick (median of {len(taken)} turns)")
    print(f"1 thread / {arguments.threads} threads: {ratio(turns):.2f} ({draws[RESAMPLES // 40]:.2f}-{draws[-1 - RESAMPLES // 40]:.2f})")


main()
