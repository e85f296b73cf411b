"""A recording through the same door: the fixture's windows, and what is refused."""
import pathlib

import numpy as np
import pytest

from egofocus_training.config import Config, RecordingConfig
from egofocus_training.errors import FILE, TrainingError
from egofocus_training.library import stack
from egofocus_training.model.network import FocusNetwork
from egofocus_training.recordings import evaluate_recording, scores

PLANES = str(pathlib.Path(__file__).resolve().parents[2] / "fixtures" / "planes")


def test_scores_by_hand():
    got = scores(np.array([[1.0, 3.0, 5.0, 7.0]]), np.array([[1.0, 2.0, 0.0, np.inf]]))
    assert got == {"pixels": 2, "abs_rel": 0.25, "median": 0.25, "within_10_percent": 0.5, "d1": 0.5}


def test_the_fixture():
    config = Config(recording=RecordingConfig(folder=PLANES, source="poses", z_near_m=0.95))
    config.network.widths, config.network.blocks = [16, 16, 16], [0, 0, 0]
    network = FocusNetwork(config.input, config.network).eval()
    means, images = evaluate_recording(network, config)
    assert images >= 20
    assert means["sgm"]["d1"] > 0.8 and means["sgm"]["median"] < 0.05  # slow ramps included
    assert 0 < means["network"]["abs_rel"] < 1  # untrained: a number, no more


def test_windows_tell_what_they_rest_on():
    recording = stack.Recording(PLANES, "odometry")
    facts = recording.tick(700_000, ["counts", "half", "cells"])
    assert facts["has_stack"] and facts["counts"].shape == (64, 180, 240) and facts["cells"].shape == (4, 64, 45, 60)
    assert facts["counts"].astype(int).sum() == facts["votes"]
    t_us, x, y, polarity = recording.events(700_000)
    assert t_us.size >= facts["events"] and t_us.max() <= 0 and x.max() < 240 and y.max() < 180
    assert set(polarity.tolist()) == {0, 1}
    assert recording.truth_m(700_000).shape == (180, 240)
    assert not recording.tick(2_100_000, [])["has_stack"]  # it stands still


def test_what_is_missing_is_named(tmp_path):
    config = Config(recording=RecordingConfig(folder=str(tmp_path)))
    with pytest.raises(TrainingError) as caught:
        evaluate_recording(None, config)
    assert caught.value.exit_code == FILE and str(tmp_path) in str(caught.value)
    config.recording = RecordingConfig(folder=PLANES, reference=str(tmp_path / "none.npz"))
    with pytest.raises(TrainingError, match="none.npz"):
        evaluate_recording(None, config)
    with pytest.raises(stack.StackError, match="odometry or poses"):
        stack.Recording(PLANES, "wheels")
