"""python3 -m egofocus_training.rounding --config FILE --weights FILE [--samples N] [--json]: what the integers cost.

For weights whose training ended with rounding ([quantise]): per tensor, how far rounding moves it (its own and all rounding
before it), and how much of it saturates; then the same network in floats, with rounding, and as the integer model, on the
same validation windows.
"""
import argparse
import json

import numpy as np
import torch

from . import errors
from .config import load_config
from .dataset import collate
from .evaluate import load_network, validation_samples
from .integer_model import IntegerModel
from .journal import Progress
from .machine import keep_freed_memory
from .metrics import MeanMetrics, depth_of, enlarge, image_metrics, pixel_sets
from .model.bytes import Bytes
from .quantisation import is_quantised, set_rounding
from .windows import network_inputs, stack_sample, wanted_arrays

WAYS = ("float", "rounded", "integer")


class Watch:
    """Every tensor that becomes bytes, of one run."""

    def __init__(self, network):
        self.tensors = {}
        self.points = {name: module for name, module in network.named_modules() if isinstance(module, Bytes)}
        for name, module in self.points.items():
            module.register_forward_hook(lambda _, __, out, name=name: self.tensors.__setitem__(name, out.detach().float()))

    def take(self):
        taken, self.tensors = self.tensors, {}
        return taken


@torch.no_grad()
def report(network, samples, config):
    """(rows of tensors, rows of MeanMetrics by way, share of pixels more than one hypothesis from float by way)"""
    watch, model = Watch(network), IntegerModel(network)
    sums = {name: np.zeros(4) for name in watch.points}  # error^2, value^2, saturated, values
    means, far = MeanMetrics(), {"rounded": [], "integer": []}
    progress = Progress("rounding", len(samples))
    for n, (shard, i) in enumerate(samples):
        progress.show(n + 1)
        sample = shard[i]
        facts = stack_sample(sample, config.input, (*wanted_arrays(), "event_mask"))
        if not facts["has_stack"]:
            continue
        inputs = network_inputs(facts)
        index, tensors = {}, {}
        for way in ("float", "rounded"):
            set_rounding(network, way == "rounded")
            index[way] = network(collate([inputs])).index[0].float().numpy()
            tensors[way] = watch.take()
        index["integer"] = model(**inputs)["index"] / 256.0
        for name, point in watch.points.items():
            exact, rounded = tensors["float"][name], tensors["rounded"][name]
            sums[name] += [((exact - rounded) ** 2).sum().item(), (exact ** 2).sum().item(),
                           (rounded >= point.high * point.scale * 0.9999).sum().item(), exact.numel()]
        masks, truth_m = pixel_sets(sample.inverse_depth, facts["event_mask"], facts["step_per_m"], facts["hypotheses"])
        height, width = truth_m.shape
        for way in WAYS:
            depth_m = depth_of(enlarge(index[way], height, width), facts["step_per_m"])
            for pixel_set in ("all", "events"):
                means.add(way, sample.family, pixel_set, image_metrics(depth_m, truth_m, masks[pixel_set], facts["step_per_m"]))
            if way != "float":
                far[way].append(float(np.mean(np.abs(index[way] - index["float"]) > 1)))
    progress.end()
    tensors = [{"tensor": name, "step": float(watch.points[name].scale), "relative_error": float(np.sqrt(s[0] / max(s[1], 1e-12))),
                "saturated": s[2] / s[3]} for name, s in sums.items()]
    return tensors, means.rows(), {way: float(np.mean(shares)) for way, shares in far.items()}


def text(tensors, rows, far):
    lines = [f"{'tensor':34} {'step':>10} {'rel. error':>10} {'saturated':>10}"]
    lines += [f"{t['tensor']:34} {t['step']:10.5f} {t['relative_error']:10.4f} {t['saturated']:10.5f}" for t in tensors]
    lines.append(f"\n{'way':8} {'set':8} {'images':>6} {'d1':>6} {'Abs.Rel':>8} {'RMSE log':>9} {'idx MAE':>8} {'> 1 off':>8}")
    for way in WAYS:
        for r in rows:
            if r["method"] == way and r["family"] == "overall":
                off = f"{far[way]:8.4f}" if way in far else ""
                lines.append(f"{way:8} {r['set']:8} {r['images']:6} {r['d1']:6.3f} {r['abs_rel']:8.4f} {r['rmse_log']:9.4f} "
                             f"{r['idx_mae']:8.4f} {off}")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(prog="egofocus_training.rounding", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--config", required=True)
    parser.add_argument("--weights", required=True)
    parser.add_argument("--samples", type=int, default=60)
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    if arguments.samples < 1:
        raise errors.TrainingError(errors.USAGE, "--samples", "is positive.")
    keep_freed_memory()
    config = load_config(arguments.config)
    samples = validation_samples(config, arguments.config, arguments.samples)
    network = load_network(arguments.weights, config)
    if not is_quantised(network):
        raise errors.TrainingError(errors.CONFIGURATION, arguments.weights, "was trained in floats to the end: set [quantise] "
                                   "last_steps and go on.")
    tensors, rows, far = report(network, samples, config)
    print(json.dumps({"tensors": tensors, "rows": rows, "off": far}) if arguments.json else text(tensors, rows, far))
    return 0


if __name__ == "__main__":
    errors.run(main)
