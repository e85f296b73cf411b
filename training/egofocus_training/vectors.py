"""python3 -m egofocus_training.vectors [--config FILE --weights FILE | --costs HIDDENxCHANNELS] --out DIR: what the runtime must say.

DIR/model.efm and DIR/cases.bin: inputs of N windows and every tensor of the integer model, for tests/pipeline/network_test.cpp. Without
--config and --weights: a little network with random weights, --costs its channels per hypothesis.
cases.bin: arrays one after the other, little-endian: name (16 bytes, zero padded), type (u32: 1 u8, 2 u16), number of dimensions
(u32), four dimensions (u32), the values, zeros up to a multiple of 8 bytes.
"""
import argparse
import pathlib
import struct

import numpy as np
import torch

from . import checkpoint, efm, errors
from .config import load_config, parse_config
from .evaluate import load_network
from .focus_input import context_channels
from .integer_model import IntegerModel
from .macs import size_of
from .model.network import FocusNetwork
from .quantisation import calibrate, set_rounding
from .units import ZERO

RANDOM = """
[input]
hypotheses = 16
maps = ["gradient:3", "squares:7", "gradient_x:1"]
[network]
cost_hidden = {}
cost_channels = {}
widths = [12, 20, 24]
blocks = [1, 1, 2]
up_blocks = [1, 1]
refine_width = 8
refine_dilations = [1, 2]
"""
_TYPES = {"uint8": 1, "uint16": 2}
_KEPT = ("cost", "a4", "a8", "a16", "b8", "b4", "index_4", "confidence", "refined", "index")


def random_window(config, seed, width, height, used):
    """Inputs that look like a window's: noise about zero, counts of a few; nothing beyond `used`."""
    random = np.random.default_rng(seed)
    h, w = -(-height // 4), -(-width // 4)

    def about_zero(*shape):
        return np.clip(np.rint(random.normal(ZERO, 12, shape)), 0, 127).astype(np.uint8)

    depth = config.input.hypotheses
    window = {"focus": about_zero(depth, len(config.input.maps), h, w), "context": about_zero(context_channels(config.input), h, w),
              "half": random.poisson(1.5, (depth, -(-height // 2), -(-width // 2))).astype(np.uint8), "used": np.int64(used)}
    window["context"][-2] = np.maximum(window["context"][-2], ZERO)  # a length
    return cut(window)


def cut(window):
    """As the library has it where the ladder ends early."""
    used = int(window["used"])
    window["focus"][used:] = ZERO
    window["half"][used:] = 0
    return window


def filled(config, width, height, used, byte, counts):
    """Every input byte the same."""
    window = random_window(config, 0, width, height, used)
    for name, value in (("focus", byte), ("context", byte), ("half", counts)):
        window[name][:] = value
    return cut(window)


def windows(config, width, height, count):
    """All hypotheses, few, one; nothing seen, everything saturated; then random ones."""
    depth = config.input.hypotheses
    special = [random_window(config, 1, width, height, depth), random_window(config, 2, width, height, depth - 3),
               random_window(config, 3, width, height, 1), random_window(config, 4, width, height, 2),
               filled(config, width, height, depth, 0, 0), filled(config, width, height, depth, 127, 255),
               filled(config, width, height, depth, ZERO, 0)]
    rest = [random_window(config, seed, width, height, 1 + seed % depth) for seed in range(10, 10 + max(count - len(special), 0))]
    return (special + rest)[:count]


def random_network(hidden=8, channels=4, seed=3):
    """(config, quantised network) with every weight away from its start, whose indices differ widely between neighbours."""
    torch.manual_seed(seed)
    config = parse_config(RANDOM.format(hidden, channels), "vectors")
    network = FocusNetwork(config.input, config.network)
    for parameter in network.parameters():
        torch.nn.init.normal_(parameter, 0.1 if parameter.ndim == 1 else 0.0, 0.1)
    for module in network.modules():
        if isinstance(module, torch.nn.BatchNorm2d):
            torch.nn.init.normal_(module.weight, 1.0, 0.2)
    torch.nn.init.normal_(network.aggregation.head.weight, 0.0, 2.0)
    torch.nn.init.normal_(network.refinement.last.weight, 0.0, 0.05)
    batches = [{name: torch.as_tensor(value)[None] for name, value in random_window(config, s, 52, 36, 13).items()} for s in range(4)]
    network.train()
    for batch in batches:
        network(batch)
    calibrate(network, batches)
    network.eval()
    set_rounding(network, True)
    return config, network


def array_bytes(name, array):
    shape = list(array.shape) + [1] * (4 - array.ndim)
    data = np.ascontiguousarray(array).astype(array.dtype.newbyteorder("<")).tobytes()
    return struct.pack("<16s6I", name.encode(), _TYPES[array.dtype.name], array.ndim, *shape) + data + bytes(-len(data) % 8)


def case_bytes(model, window, everything):
    """One window: its inputs and the model's tensors, or its outputs alone."""
    tensors = model(**window)
    out = b"".join(array_bytes(name, window[name]) for name in ("focus", "context", "half"))
    out += array_bytes("used", np.array([window["used"]], np.uint16))
    for name in _KEPT if everything else ("index_4", "confidence", "index"):
        tensor = tensors[name]
        kind = np.uint16 if name.startswith("index") else np.uint8
        out += array_bytes(name, (tensor.reshape(-1, *tensor.shape[-2:]) if name == "cost" else tensor).astype(kind))
    return out


def main():
    parser = argparse.ArgumentParser(prog="egofocus_training.vectors", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--config")
    parser.add_argument("--weights")
    parser.add_argument("--costs", default="8x4", help="of the random network: HIDDENxCHANNELS; 0 hidden: one convolution")
    parser.add_argument("--out", required=True)
    parser.add_argument("--size", default="35x45", help="the working grid, WIDTHxHEIGHT in px")
    parser.add_argument("--cases", type=int, default=7)
    parser.add_argument("--whole", type=int, default=1, help="so many cases have every tensor, the others their outputs")
    arguments = parser.parse_args()
    width, height = size_of(arguments.size)
    if (arguments.config is None) != (arguments.weights is None):
        raise errors.TrainingError(errors.USAGE, "--config and --weights", "belong together.")
    if arguments.config:
        config = load_config(arguments.config)
        network = load_network(arguments.weights, config)
        state = checkpoint.read(arguments.weights)
    else:
        config, network = random_network(*map(int, arguments.costs.split("x")))
        state = {}
    out = pathlib.Path(arguments.out)
    out.mkdir(parents=True, exist_ok=True)
    model = IntegerModel(network)
    card = efm.card_of("vectors" if arguments.config else "random", config, state)
    efm.write_model(out / "model.efm", efm.model_bytes(model, config, card))
    cases = [case_bytes(model, window, n < arguments.whole)
             for n, window in enumerate(windows(config, width, height, arguments.cases))]
    (out / "cases.bin").write_bytes(b"".join(cases))
    for name in ("model.efm", "cases.bin"):
        print(f"{out / name}  {(out / name).stat().st_size / 1024:.0f} KiB")
    return 0


if __name__ == "__main__":
    errors.run(main)
