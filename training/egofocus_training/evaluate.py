"""python3 -m egofocus_training.evaluate --config FILE --weights FILE [--samples N] [--json]: a network on validation shards.

Beside it, on the same pixels: the classical backend on the same stack (focus argmax, and with semi-global smoothing; a
pixel without an estimate counts as 80 m) and the median of each image's own truth, which no method has.
"""
import argparse
import json

import numpy as np
import torch

from . import checkpoint, errors
from .config import load_config
from .dataset import collate, spread
from .journal import Progress
from .machine import keep_freed_memory
from .metrics import SETS, MeanMetrics, depth_of, enlarge, image_metrics, pixel_sets
from .model.build import network_of
from .quantisation import set_rounding
from .samples import Shard, split_shards
from .windows import network_inputs, sample_facts


def spread_over(paths, count):
    """(shard, index) of `count` samples, evenly over the shards' samples."""
    shards = [Shard(path) for path in paths]
    everything = [(shard, i) for shard in shards for i in range(len(shard))]
    return [everything[i] for i in spread(len(everything), count)]


def validation_samples(config, where, count=None):
    """(shard, index) of `count` validation windows, or as many as the config says."""
    _, paths = split_shards(config.data)
    if not paths:
        raise errors.TrainingError(errors.CONFIGURATION, where, "names no validation shards: set [data] validation or "
                                   "hold_out_every.")
    return spread_over(paths, count or config.data.validation_samples)


@torch.no_grad()
def predicted_index(network, facts, config):
    """Index at full resolution, float [height, width]."""
    inputs = collate([network_inputs(facts, config.network.order)])
    device = next(network.parameters()).device
    prediction = network({name: tensor.to(device) for name, tensor in inputs.items()})
    width, height = facts["grid"][:2]
    return enlarge(prediction.index[0].float().cpu().numpy(), height, width)


def evaluate(network, samples, config, classical=True):
    """Rows of MeanMetrics over samples [(shard, index)]. The network may be None."""
    means = MeanMetrics()
    progress = Progress("evaluate", len(samples))
    more = ("event_mask", *(("argmax", "sgm") if classical else ()))
    if network is not None:
        network.eval()
    without = 0
    for n, (shard, i) in enumerate(samples):
        sample = shard[i]
        facts = sample_facts(sample, config, more)
        progress.show(n + 1)
        if not facts["has_stack"]:
            without += 1
            continue
        step = facts["step_per_m"]
        masks, truth_m = pixel_sets(sample.inverse_depth, facts["event_mask"], step, facts["hypotheses"])
        estimates = {}
        if network is not None:
            estimates["network"] = depth_of(predicted_index(network, facts, config), step)
        if classical:
            for name in ("argmax", "sgm"):
                index = np.where(facts[f"{name}_confidence"] > 0, facts[name] / 256.0, 0)
                estimates[name] = depth_of(index, step)
            if masks["all"].any():
                estimates["median"] = np.full(truth_m.shape, np.median(truth_m[masks["all"]]))
        for method, depth_m in estimates.items():
            for pixel_set in SETS:
                means.add(method, sample.family, pixel_set, image_metrics(depth_m, truth_m, masks[pixel_set], step))
    progress.end()
    return means.rows(), without


def table(rows):
    """The rows as text."""
    lines = [f"{'family':12} {'set':17} {'method':8} {'images':>6} {'d1':>6} {'Abs.Rel':>8} {'RMSE log':>9} {'idx MAE':>8}"]
    for r in sorted(rows, key=lambda r: (r["family"] != "overall", r["family"], SETS.index(r["set"]), r["method"])):
        lines.append(f"{r['family']:12} {r['set']:17} {r['method']:8} {r['images']:6} {r['d1']:6.3f} {r['abs_rel']:8.3f} "
                     f"{r['rmse_log']:9.3f} {r['idx_mae']:8.3f}")
    return "\n".join(lines)


def load_network(path, config):
    """The network of a weights file or a checkpoint's average. TrainingError as checkpoint.read()."""
    state = checkpoint.read(path)
    checkpoint.require_same_network(path, state, config)
    network = network_of(config)
    checkpoint.load_weights(network, state.get("average", state["network"]), path)
    if state["quantised"]:
        set_rounding(network, True)
    return network.eval().to(memory_format=torch.channels_last)


def main():
    parser = argparse.ArgumentParser(prog="egofocus_training.evaluate", description=__doc__)
    parser.add_argument("--config", required=True)
    parser.add_argument("--weights", help="weights.pt or checkpoint.pt; without it the classical backend alone")
    parser.add_argument("--samples", type=int, help="in place of the config's validation_samples")
    parser.add_argument("--regression", choices=("median", "expectation"), help="in place of the config's, with the same weights")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    if arguments.samples is not None and arguments.samples < 1:
        raise errors.TrainingError(errors.USAGE, "--samples", "is positive.")
    keep_freed_memory()
    config = load_config(arguments.config)
    samples = validation_samples(config, arguments.config, arguments.samples)
    network = load_network(arguments.weights, config) if arguments.weights else None
    if network is not None and arguments.regression:
        network.median = arguments.regression == "median"
    rows, without = evaluate(network, samples, config)
    if arguments.json:
        print(json.dumps({"rows": rows, "without_parallax": without}))
    else:
        print(table(rows))
        print(f"{without} windows without parallax left out")
    return 0


if __name__ == "__main__":
    errors.run(main)
