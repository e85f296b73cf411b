"""`egofocus eval` with the network is the integer model on the same windows: every pixel, and every figure to the last digit."""
import json
import os
import pathlib
import subprocess
import tomllib

import numpy as np
import pytest

from egofocus_training.config import load_config
from egofocus_training.evaluate import load_network
from egofocus_training.integer_model import IntegerModel
from egofocus_training.library import stack
from egofocus_training.metrics import CLIP_M, CUT_M, NAMES, enlarge_q8, image_metrics
from egofocus_training.windows import ladder_of, network_inputs, recording_facts

ROOT = pathlib.Path(__file__).resolve().parents[2]
TOWN = ROOT / "fixtures" / "town5_night"
IMAGES = 5


def run_eval(model, out):
    program = os.environ.get("EGOFOCUS_APP")
    if not program:
        pytest.skip("EGOFOCUS_APP names no egofocus: ctest does")
    text = subprocess.run([program, "eval", str(TOWN), "--methods", "network", "--model", str(model / f"{model.name}.efm"), "--limit",
                           str(IMAGES), "--out", str(out / "maps"), "--json", str(out / "scores.json")],
                          check=True, capture_output=True, text=True).stdout
    return text, json.loads((out / "scores.json").read_text())["recordings"][0]


@pytest.mark.parametrize("name", ["base", "small"])
def test_the_runtimes_numbers_are_the_integer_models(name, tmp_path):
    folder = ROOT / "models" / name
    text, scores = run_eval(folder, tmp_path)
    config = load_config(folder / "config.toml")
    model = IntegerModel(load_network(folder / "weights.pt", config))
    z_near_m = tomllib.loads((TOWN / "camera.toml").read_text())["ladder"]["z_near_m"]
    recording = stack.Recording(str(TOWN), None, ladder_of(config.input, z_near_m))
    assert len(scores["images"]) == IMAGES
    found = []
    for image in scores["images"]:
        facts = recording_facts(recording, image["t_us"], config)
        assert facts["has_stack"] and facts["hypotheses"] == image["hypotheses"] and facts["step_per_m"] == image["step_per_m"]
        theirs = model(**network_inputs(facts))
        truth_m = recording.truth_m(image["t_us"])
        height, width = truth_m.shape
        index_q8 = enlarge_q8(theirs["index"], height, width)
        with np.errstate(divide="ignore"):
            depth_m = (1.0 / (index_q8 * (facts["step_per_m"] / 256.0))).astype(np.float32)
        confidence = np.maximum(theirs["confidence"], 1)[np.ix_(np.arange(height) // 4, np.arange(width) // 4)]
        ours = tmp_path / "maps" / TOWN.name / "network" / f"{image['t_us']:012d}"
        assert np.array_equal(np.load(f"{ours}.npy"), depth_m)
        assert np.array_equal(np.load(f"{ours}_confidence.npy"), confidence)
        truth_m = truth_m.astype(np.float64)
        known = np.isfinite(truth_m) & (truth_m > 0) & (truth_m <= CUT_M)
        found.append(image_metrics(np.clip(depth_m.astype(np.float64), *CLIP_M), truth_m, known, facts["step_per_m"]))
    runtime = scores["methods"][0]["all"]
    row = next(line for line in text.splitlines() if line.startswith("network")).split()
    for name in NAMES:
        mean = float(np.mean([of[name] for of in found]))
        assert runtime[name] == pytest.approx(mean, rel=1e-12), name
        assert f"{mean:.4f}" in row, name
