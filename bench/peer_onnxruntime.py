"""peer_onnxruntime.py --frames PROGRAM --onnx DIR [--modules DIR]: the whole network, ours and ONNX Runtime's, one thread, in turns.

PROGRAM  network_frames of the build
--onnx   a folder that egofocus_training.export and egofocus_training.vectors --cases 1 --size 346x260 have filled from the same weights
--modules  where `npm install --ignore-scripts onnxruntime-node` was run (default: ~/.cache/egofocus/onnxruntime)
Both run as processes that wait for their turn; turns are of 20 frames, in random order; times are processor time of the process. The
graphs: qdq.onnx as exported, and qdq_pairs.onnx, made here: without the clips at 127, and with byte pairs after every convolution, so
that the runtime can keep each one in integers. Its outputs are not the network's; only its speed counts.
Peaks of memory are those after loading and one frame. Exit code: 0; 2 usage; 3 something is missing.
"""
import argparse
import json
import pathlib
import random
import statistics
import subprocess
import sys

HERE = pathlib.Path(__file__).parent
RESAMPLES = 1000


def pairs_everywhere(source, target):
    """Writes the graph in which ONNX Runtime finds a convolution of bytes at each Conv."""
    import onnx
    from onnx import helper, numpy_helper
    import numpy as np

    model = onnx.load(str(source))
    graph = model.graph
    made_by = {name: n for n in graph.node for name in n.output}
    for node in [n for n in graph.node if n.op_type == "Clip"]:
        if made_by[node.input[0]].op_type == "QuantizeLinear":
            for reader in graph.node:
                reader.input[:] = [node.input[0] if name == node.output[0] else name for name in reader.input]
            graph.node.remove(node)
    readers = {}
    for node in graph.node:
        for name in node.input:
            readers.setdefault(name, []).append(node)
    added = 0
    for node in [n for n in graph.node if n.op_type == "Conv"]:
        last = node
        while len(readers.get(last.output[0], ())) == 1 and readers[last.output[0]][0].op_type in ("Relu", "Clip"):
            last = readers[last.output[0]][0]
        after = readers.get(last.output[0], ())
        if after and all(n.op_type == "QuantizeLinear" for n in after):
            continue
        name = f"pair_{added}"
        added += 1
        graph.initializer.extend([numpy_helper.from_array(np.float32(0.05), f"{name}_scale"),
                                  numpy_helper.from_array(np.uint8(128), f"{name}_zero")])
        old, new = last.output[0], f"{name}_out"
        for reader in after:
            reader.input[:] = [new if i == old else i for i in reader.input]
        at = list(graph.node).index(last) + 1
        for k, (kind, inputs, output) in enumerate([("QuantizeLinear", old, f"{name}_bytes"), ("DequantizeLinear", f"{name}_bytes", new)]):
            graph.node.insert(at + k, helper.make_node(kind, [inputs, f"{name}_scale", f"{name}_zero"], [output]))
    onnx.checker.check_model(model)
    onnx.save(model, str(target))


class Runner:
    """A process that says its peak, then runs as many frames as it is told."""

    def __init__(self, command, says_apart):
        self.process = subprocess.Popen([str(c) for c in command], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.peak_kib = int(self._line("peak").split()[1])
        self.apart = float(self._line("apart").split()[1]) if says_apart else 0.0
        self.turns = []

    def _line(self, begin=""):
        line = self.process.stdout.readline()
        if not line.startswith(begin) or not line:
            sys.exit(f"error: {self.process.args[0]} {self.process.args[-1]} ended early (exit code {self.process.wait()})")
        return line

    def turn(self, frames):
        self.process.stdin.write(f"{frames}\n")
        self.process.stdin.flush()
        self.turns.append(statistics.median(float(word) for word in self._line().split()))


def interval(ours, theirs, generator):
    """(theirs / ours, low, high): medians over turns; the middle 95 % of bootstrap draws of turns."""
    def ratio(turns):
        return statistics.median(theirs[t] for t in turns) / statistics.median(ours[t] for t in turns)

    count = len(ours)
    draws = sorted(ratio([generator.randrange(count) for _ in range(count)]) for _ in range(RESAMPLES))
    return ratio(range(count)), draws[RESAMPLES // 40], draws[-1 - RESAMPLES // 40]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", required=True, type=pathlib.Path)
    parser.add_argument("--onnx", required=True, type=pathlib.Path)
    parser.add_argument("--modules", type=pathlib.Path, default=pathlib.Path.home() / ".cache/egofocus/onnxruntime")
    parser.add_argument("--turns", type=int, default=20)
    parser.add_argument("--json", type=pathlib.Path)
    arguments = parser.parse_args()
    package = arguments.modules / "node_modules/onnxruntime-node/package.json"
    for path, mend in ((package, f"run: mkdir -p {arguments.modules} && npm install --ignore-scripts --prefix {arguments.modules} onnxruntime-node"),
                       (arguments.onnx / "qdq.onnx", "see --help"), (arguments.onnx / "cases.bin", "see --help")):
        if not path.exists():
            print(f"error: {path} is missing; {mend}", file=sys.stderr)
            return 3
    pairs_everywhere(arguments.onnx / "qdq.onnx", arguments.onnx / "qdq_pairs.onnx")
    peer = ["node", HERE / "peer_onnxruntime.mjs", arguments.modules, arguments.onnx]
    runners = {"ours": Runner([arguments.frames, arguments.onnx / "model.efm", arguments.onnx / "cases.bin"], False)}
    for graph in ("qdq.onnx", "qdq_pairs.onnx", "float.onnx", "none"):
        runners[graph] = Runner([*peer, graph], True)
    generator = random.Random(1)
    timed = [name for name in runners if name != "none"]
    for name in timed:
        runners[name].turn(10)
        runners[name].turns.clear()
    for _ in range(arguments.turns):
        for name in generator.sample(timed, len(timed)):
            runners[name].turn(20)
    version = json.loads(package.read_text(encoding="utf-8"))["version"]
    print(f"ONNX Runtime {version} (node), one thread, {arguments.turns} turns of 20 frames")
    ours = runners["ours"]
    result = {}
    for name, runner in runners.items():
        row = {"peak_kib": runner.peak_kib}
        text = f"{name:16s} {'':8s} {'':29s}"
        if name in timed:
            row |= {"ms": statistics.median(runner.turns), "ratio": interval(ours.turns, runner.turns, generator), "apart": runner.apart}
            value, low, high = row["ratio"]
            text = f"{name:16s} {row['ms']:6.2f} ms ours/its {value:.2f} ({low:.2f} .. {high:.2f})"
        print(f"{text}  peak {runner.peak_kib / 1024:6.1f} MiB" + (f"  index {runner.apart:.3f} apart" if name in timed else ""))
        result[name] = row
    if arguments.json:
        arguments.json.write_text(json.dumps({"onnxruntime": version, "turns": arguments.turns, "rows": result}, indent=1), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
