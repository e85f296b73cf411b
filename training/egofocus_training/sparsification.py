"""python3 -m egofocus_training.sparsification --config FILE --weights FILE [--samples N] [--plot PNG] [--json]: does the
confidence know where the depth is wrong?

Pixels are removed from the least trusted up, 0 to 95 % in steps of 5 % (among equals: the expectation over all orders), and the
error of the rest is drawn over the share removed: by
    confidence  the network's own
    parallax    that of the estimate alone
    entropy     of the softmax alone, the smaller the better
    oracle      removes the worst pixels first
AUSE: area between a curve and the oracle's. Curves are means over validation windows, as in `egofocus eval`.
"""
import argparse
import json

import numpy as np
import torch

from . import errors
from .config import load_config
from .dataset import collate
from .evaluate import load_network, validation_samples
from .journal import Progress, draw_curves
from .machine import keep_freed_memory
from .metrics import SETS, depth_of, enlarge, pixel_sets
from .model.regression import distribution
from .windows import network_inputs, sample_facts

STEPS = 20  # shares removed: k / STEPS
METRICS = ("abs_rel", "rmse_log")
WAYS = ("confidence", "parallax", "entropy", "oracle")


def curve(values, trust):
    """Mean of what is left, for each share removed, [STEPS]; values and trust [n], n > 0."""
    _, level, count = np.unique(trust, return_inverse=True, return_counts=True)
    expected = np.bincount(level, values) / count
    sums = np.cumsum(expected[np.sort(level)[::-1]])
    kept = values.size - values.size * np.arange(STEPS) // STEPS
    return sums[kept - 1] / kept


def area(values):
    """Under a curve, by trapezoids."""
    return float(np.sum(values[1:] + values[:-1]) / 2 / STEPS)


def curves_of(depth_m, truth_m, trusts):
    """{(metric, way): curve} over pixels [n]; trusts: {way: [n]}, the oracle is added."""
    out = {}
    for metric, values in (("abs_rel", np.abs(depth_m - truth_m) / truth_m), ("rmse_log", np.square(np.log(depth_m / truth_m)))):
        for way, trust in {**trusts, "oracle": -values}.items():
            found = curve(values, trust)
            out[metric, way] = np.sqrt(found) if metric == "rmse_log" else found
    return out


@torch.no_grad()
def trusts_of(network, facts, config):
    """(index [h, w], {way: trust [h, w]}) of a window; trusts are those of the cells of 4x4 px."""
    inputs = collate([network_inputs(facts, config.network.order)])
    prediction = network(inputs)
    p = distribution(prediction.scores, inputs["used"])
    index, step_px = prediction.index_4, prediction.step_px
    trusts = {"confidence": prediction.confidence, "parallax": index * step_px,
              "entropy": (p * torch.log(p.clamp(min=1e-12))).sum(1)}
    width, height = facts["grid"][:2]

    return enlarge(prediction.index[0].float().numpy(), height, width), \
        {way: np.kron(trust[0].float().numpy(), np.ones((4, 4)))[:height, :width] for way, trust in trusts.items()}


def sparsification(network, samples, config):
    """[{set, metric, images, areas {way}, ause {way}, curves {way}}] over samples [(shard, index)]."""
    sums = {}
    progress = Progress("sparsification", len(samples))
    for n, (shard, i) in enumerate(samples):
        progress.show(n + 1)
        sample = shard[i]
        facts = sample_facts(sample, config, ("event_mask",))
        if not facts["has_stack"]:
            continue
        index, trusts = trusts_of(network, facts, config)
        depth_m = depth_of(index, facts["step_per_m"])
        masks, truth_m = pixel_sets(sample.inverse_depth, facts["event_mask"], facts["step_per_m"], facts["hypotheses"])
        for pixel_set in SETS:
            mask = masks[pixel_set]
            if mask.any():
                mine = curves_of(depth_m[mask], truth_m[mask], {way: trust[mask] for way, trust in trusts.items()})
                for key, values in mine.items():
                    sums.setdefault((pixel_set, *key), []).append(values)
    progress.end()
    rows = []
    for pixel_set in SETS:
        for metric in METRICS:
            if (pixel_set, metric, "oracle") in sums:
                curves = {way: np.mean(sums[pixel_set, metric, way], axis=0) for way in WAYS}
                areas = {way: area(values) for way, values in curves.items()}
                rows.append({"set": pixel_set, "metric": metric, "images": len(sums[pixel_set, metric, "oracle"]), "areas": areas,
                             "ause": {way: areas[way] - areas["oracle"] for way in WAYS[:-1]},
                             "curves": {way: values.tolist() for way, values in curves.items()}})
    return rows


def text(rows):
    lines = [f"{'set':17} {'error':8} {'images':>6} " + " ".join(f"{way:>10}" for way in WAYS) + "  AUSE: "
             + " ".join(f"{way:>10}" for way in WAYS[:-1])]
    for r in rows:
        lines.append(f"{r['set']:17} {r['metric']:8} {r['images']:6} " + " ".join(f"{r['areas'][way]:10.4f}" for way in WAYS)
                     + "        " + " ".join(f"{r['ause'][way]:10.4f}" for way in WAYS[:-1]))
    return "\n".join(lines)


def draw(rows, path):
    series, panels = {}, []
    for r in rows:
        names = {way: f"{r['set']}:{r['metric']}:{way}" for way in WAYS}
        panels.append(" ".join(names.values()))
        for way, values in r["curves"].items():
            series[names[way]] = [(100 * k // STEPS, value) for k, value in enumerate(values)]
    draw_curves(series, path, panels, "% removed:")


def main():
    parser = argparse.ArgumentParser(prog="egofocus_training.sparsification", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--config", required=True)
    parser.add_argument("--weights", required=True)
    parser.add_argument("--samples", type=int, default=60)
    parser.add_argument("--plot", help="a picture of the curves")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    if arguments.samples < 1:
        raise errors.TrainingError(errors.USAGE, "--samples", "is positive.")
    keep_freed_memory()
    config = load_config(arguments.config)
    samples = validation_samples(config, arguments.config, arguments.samples)
    rows = sparsification(load_network(arguments.weights, config), samples, config)
    if arguments.plot:
        try:
            draw(rows, arguments.plot)
        except OSError as error:
            raise errors.TrainingError(errors.FILE, arguments.plot, f"cannot be written ({error}).") from None
    print(json.dumps(rows) if arguments.json else text(rows))
    return 0


if __name__ == "__main__":
    errors.run(main)
