"""Curves by hand, and on windows: where nothing is removed they are the evaluation's own figures."""
import json

import numpy as np
import pytest
import small_world
import torch

from egofocus_training import sparsification as program
from egofocus_training.config import load_config
from egofocus_training.evaluate import evaluate, validation_samples
from egofocus_training.sparsification import WAYS, area, curve, curves_of, sparsification
from egofocus_training.trainer import Trainer


def test_curves_by_hand():
    values = np.arange(20.0)
    best = curve(values, -values)
    assert best.tolist() == [np.arange(20 - k).mean() for k in range(20)]
    assert curve(values, values).tolist() == [np.arange(k, 20).mean() for k in range(20)]
    assert curve(values, np.zeros(20)).tolist() == [9.5] * 20  # knows nothing: flat
    # Of two equals the expectation: 0 and 2 are kept with the same chance.
    assert curve(np.array([0.0, 2, 5, 7]), np.array([1.0, 1, 0, 0]))[[0, 5, 10, 15]].tolist() == [3.5, 8 / 3, 1, 1]
    assert area(np.full(20, 2.0)) == pytest.approx(2 * 0.95)
    assert curve(np.array([3.0]), np.array([1.0])).tolist() == [3.0] * 20


def test_errors_by_hand():
    truth = np.array([1.0, 2.0])
    got = curves_of(np.array([1.0, 3.0]), truth, {"confidence": np.array([0.2, 0.9])})
    assert got["abs_rel", "confidence"][[0, 10, 19]].tolist() == pytest.approx([0.25, 0.5, 0.5])  # trusts the wrong one
    assert got["rmse_log", "oracle"][[0, 10]].tolist() == pytest.approx([np.log(1.5) / 2 ** 0.5, 0])


@pytest.fixture()
def trained(tmp_path):
    small_world.write_shards(tmp_path / "shards", [small_world.varied_records(4), small_world.varied_records(4, 100)])
    (tmp_path / "config.toml").write_text(small_world.CONFIG.format("steps = 2"))
    config = load_config(tmp_path / "config.toml")
    trainer = Trainer(config, lambda: [tmp_path / "shards" / "shard_000001.egs"])
    with torch.no_grad():
        for p in trainer.average.network.parameters():
            p.add_(0.05 * torch.randn_like(p))
    trainer.save(tmp_path)
    return tmp_path, config, trainer.average.network


def test_nothing_removed_is_the_evaluation(trained):
    folder, config, network = trained
    samples = validation_samples(config, "test", 3)
    rows = sparsification(network, samples, config)
    assert [(r["set"], r["metric"]) for r in rows][:3] == [("all", "abs_rel"), ("all", "rmse_log"), ("events", "abs_rel")]
    figures = {r["set"]: r for r in evaluate(network, samples, config, classical=False)[0] if r["family"] == "overall"}
    for r in rows:
        assert r["images"] == figures[r["set"]]["images"] == 3
        for way in WAYS:
            # Roots of means: the curves agree with the evaluation image by image, and so in the mean.
            assert r["curves"][way][0] == pytest.approx(figures[r["set"]][r["metric"]])
            assert all(mine >= oracle - 1e-12 for mine, oracle in zip(r["curves"][way], r["curves"]["oracle"]))
            assert way == "oracle" or r["ause"][way] == pytest.approx(r["areas"][way] - r["areas"]["oracle"])
    assert len({round(rows[0]["areas"][way], 9) for way in WAYS}) == len(WAYS)  # all different orders


def test_the_program(trained, monkeypatch, capsys):
    folder, *_ = trained
    arguments = ["sparsification", "--config", str(folder / "config.toml"), "--weights", str(folder / "weights.pt"), "--samples", "2"]
    monkeypatch.setattr("sys.argv", [*arguments, "--plot", str(folder / "curves.png"), "--json"])
    assert program.main() == 0
    rows = json.loads(capsys.readouterr().out)
    assert len(rows) == 8 and len(rows[0]["curves"]["entropy"]) == 20
    assert (folder / "curves.png").read_bytes()[1:4] == b"PNG"
    monkeypatch.setattr("sys.argv", arguments)
    assert program.main() == 0 and "AUSE" in capsys.readouterr().out
