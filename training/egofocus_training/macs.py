"""python3 -m egofocus_training.macs --config FILE [--size WxH] [--json]: what the network costs, layer by layer."""
import argparse
import json

import torch
from torch import nn

from . import errors
from .config import load_config
from .focus_input import context_channels
from .model.build import network_of
from .voxels import MOTIONS


def example_input(config, width, height, batch=1):
    """Zeros in the shapes of a window of this size."""
    depth = config.input.hypotheses
    h, w = -(-height // 4), -(-width // 4)
    h2, w2 = -(-height // 2), -(-width // 2)
    used = torch.full((batch,), depth)
    if config.network.order == "recurrent":
        r = config.recurrent
        return {"slices": torch.zeros(batch, r.slices, r.bins, height, width, dtype=torch.int8),
                "motion": torch.zeros(batch, r.slices, MOTIONS), "rays": torch.zeros(batch, 2, h2, w2), "used": used}
    inputs = {"focus": torch.zeros(batch, depth, len(config.input.maps), h, w, dtype=torch.uint8),
              "context": torch.zeros(batch, context_channels(config.input), h, w, dtype=torch.uint8),
              "half": torch.zeros(batch, depth, h2, w2, dtype=torch.uint8), "used": used}
    if config.network.order == "published":
        inputs["counts"] = torch.zeros(batch, depth, height, width, dtype=torch.uint8)
    return inputs


def layer_table(config, width, height):
    """One dict per convolution in the order they run: name, kind, MACs (of all the times that it runs), bytes of int8 weights
    (with int32 bias and scale)."""
    network = network_of(config).eval()
    rows = {}

    def watch(name, conv):
        def hook(_, inputs, output):
            if name in rows:
                rows[name]["macs"] += output.numel() * per_output
                rows[name]["output_bytes"] += output.numel()
                return
            rows[name] = {"layer": name,
                          "kind": f"{'depthwise' if conv.groups > 1 else 'conv'} {kernel}x{kernel}"
                                  + (f" /{conv.stride[0]}" if conv.stride[0] > 1 else "")
                                  + (f" dilation {conv.dilation[0]}" if conv.dilation[0] > 1 else ""),
                          "channels": f"{conv.in_channels} -> {conv.out_channels}",
                          "output": (f"{output.shape[0]} x " if output.shape[0] > 1 else "") + f"{output.shape[3]}x{output.shape[2]}",
                          "macs": output.numel() * per_output,
                          "weight_bytes": conv.weight.numel() + 8 * conv.out_channels,
                          "output_bytes": output.numel()}

        kernel = conv.kernel_size[0]
        per_output = conv.in_channels // conv.groups * kernel * kernel
        conv.register_forward_hook(hook)

    for name, module in network.named_modules():
        if isinstance(module, nn.Conv2d):
            watch(name, module)
    with torch.no_grad():
        network(example_input(config, width, height))
    return list(rows.values())


def totals(rows):
    return {"macs": sum(r["macs"] for r in rows), "weight_bytes": sum(r["weight_bytes"] for r in rows)}


def size_of(text):
    """(width, height) of a --size."""
    try:
        width, height = (int(n) for n in text.split("x"))
        if min(width, height) < 32:
            raise ValueError
    except ValueError:
        raise errors.TrainingError(errors.USAGE, "--size", "is WIDTHxHEIGHT, both at least 32.") from None
    return width, height


def main():
    parser = argparse.ArgumentParser(prog="egofocus_training.macs", description=__doc__)
    parser.add_argument("--config", required=True)
    parser.add_argument("--size", default="346x260", help="the working grid, WIDTHxHEIGHT in px")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    width, height = size_of(arguments.size)
    rows = layer_table(load_config(arguments.config), width, height)
    total = totals(rows)
    if arguments.json:
        print(json.dumps({"size": [width, height], **total, "layers": rows}))
        return 0
    print(f"{'layer':38} {'kind':22} {'channels':>12} {'output':>12} {'MMAC':>8} {'KiB int8':>9}")
    for r in rows:
        print(f"{r['layer']:38} {r['kind']:22} {r['channels']:>12} {r['output']:>12} {r['macs'] / 1e6:8.1f} "
              f"{r['weight_bytes'] / 1024:9.1f}")
    print(f"{'total at ' + arguments.size:86} {total['macs'] / 1e6:8.1f} {total['weight_bytes'] / 1024:9.1f}")
    return 0


if __name__ == "__main__":
    errors.run(main)
