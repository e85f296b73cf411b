"""python3 -m egofocus_training.recordings --config FILE --weights FILE [--json]: a network on a recording, real or not.

The recording, its reference and the time are the config's [recording]. Every reference pixel counts, whatever the confidence;
the classical backend with semi-global smoothing on the same stack beside it. For looking at, never for choosing a checkpoint.
"""
import argparse
import json
import pathlib

import numpy as np

from . import errors, library
from .config import load_config
from .evaluate import load_network, predicted_index
from .machine import keep_freed_memory
from .metrics import depth_of
from .windows import ladder_of, recording_facts


def reference_of(recording, config):
    """[(time us, depth m [h, w], 0 where unknown)]: the npz of the config, or the recording's own depth pictures."""
    if not config.reference:
        return [(t, recording.truth_m(t)) for t in recording.truth_times_us()]
    try:
        with np.load(config.reference) as file:
            depth_m, valid = file["depth"], file["valid"]
    except (OSError, KeyError, ValueError) as error:
        raise errors.TrainingError(errors.FILE, config.reference, f"has no depth and valid to compare with ({error}).") from None
    return [(config.at_us, np.where(valid, depth_m, 0))]


def scores(depth_m, truth_m):
    known = np.isfinite(truth_m) & (truth_m > 0) & (truth_m <= 80)
    d, g = depth_m[known], truth_m[known]
    error = np.abs(d - g) / g
    return {"pixels": int(known.sum()), "abs_rel": float(error.mean()), "median": float(np.median(error)),
            "within_10_percent": float(np.mean(error <= 0.1)), "d1": float(np.mean(np.maximum(d / g, g / d) < 1.25))}


def evaluate_recording(network, config):
    """Means over the references that have a window: {method: {abs_rel, median, within_10_percent, d1, pixels}}, and how many."""
    place = config.recording
    try:
        recording = library.stack.Recording(place.folder, place.source or None, ladder_of(config.input, place.z_near_m))
        found = []
        for t_us, truth_m in reference_of(recording, place):
            facts = recording_facts(recording, t_us, config, ("sgm",))
            if not facts["has_stack"]:
                continue
            step = facts["step_per_m"]
            index = np.where(facts["sgm_confidence"] > 0, facts["sgm"] / 256.0, 0)
            methods = {"sgm": depth_of(index, step)}
            if network is not None:
                methods["network"] = depth_of(predicted_index(network, facts, config), step)
            found.append({name: scores(depth_m, truth_m) for name, depth_m in methods.items()})
    except library.stack.StackError as error:
        raise errors.TrainingError(errors.FILE, place.folder, str(error)) from None
    return {name: {key: float(np.mean([f[name][key] for f in found])) for key in found[0][name]}
            for name in (found[0] if found else {})}, len(found)


def main():
    parser = argparse.ArgumentParser(prog="egofocus_training.recordings", description=__doc__)
    parser.add_argument("--config", required=True)
    parser.add_argument("--weights")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    keep_freed_memory()
    config = load_config(arguments.config)
    if not config.recording.folder:
        raise errors.TrainingError(errors.CONFIGURATION, arguments.config, "names no recording: set [recording] folder.")
    network = load_network(arguments.weights, config) if arguments.weights else None
    means, count = evaluate_recording(network, config)
    if arguments.json:
        print(json.dumps({"images": count, "methods": means}))
        return 0
    print(f"{pathlib.Path(config.recording.folder).name}: {count} images")
    for name, row in means.items():
        print(f"{name:8} Abs.Rel {row['abs_rel']:.3f}  d1 {row['d1']:.3f}  median {100 * row['median']:.1f} %  "
              f"within 10 % {100 * row['within_10_percent']:.1f} %  of {row['pixels']:.0f} px")
    return 0


if __name__ == "__main__":
    errors.run(main)
