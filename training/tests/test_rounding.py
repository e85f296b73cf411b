"""The report of what the integers cost."""
import json

import pytest
import small_world

from egofocus_training import rounding
from egofocus_training.config import load_config
from egofocus_training.errors import CONFIGURATION, TrainingError
from egofocus_training.samples import find_shards
from egofocus_training.trainer import Trainer


def program(folder, monkeypatch, *options):
    monkeypatch.setattr("sys.argv", ["rounding", "--config", str(folder / "c.toml"), "--weights", str(folder / "weights.pt"),
                                     "--samples", "3", *options])
    return rounding.main()


@pytest.mark.parametrize("last_steps", [0, 2])
def test_each_tensor_and_each_way_has_its_row(tmp_path, monkeypatch, capsys, last_steps):
    small_world.write_shards(tmp_path / "shards", [small_world.varied_records(4), small_world.varied_records(4, 100)])
    (tmp_path / "c.toml").write_text(small_world.CONFIG.format(
        f"steps = 4\nwarmup_steps = 1\n[quantise]\nlast_steps = {last_steps}\ncalibration_batches = 2"))
    config = load_config(tmp_path / "c.toml")
    trainer = Trainer(config, lambda: find_shards(config.data.train)[:1])
    trainer.run(4, lambda terms: None)
    trainer.save(tmp_path)
    if last_steps == 0:
        with pytest.raises(TrainingError, match="in floats to the end") as caught:
            program(tmp_path, monkeypatch)
        assert caught.value.exit_code == CONFIGURATION
        return
    assert program(tmp_path, monkeypatch, "--json") == 0
    out = json.loads(capsys.readouterr().out)
    assert {r["method"] for r in out["rows"]} == {"float", "rounded", "integer"}
    tensors = {t["tensor"]: t for t in out["tensors"]}
    assert {"fcd.filter.1.3", "aggregation.join_4.sum", "refinement.change"} <= set(tensors)
    assert 0 < tensors["aggregation.up_4.0.sum"]["relative_error"] < 0.2
    assert {t["tensor"]: t for t in tensors.values() if t["saturated"] >= 0.05} == {}
    means = {r["method"]: r["abs_rel"] for r in out["rows"] if r["set"] == "all" and r["family"] == "overall"}
    assert means["rounded"] == pytest.approx(means["integer"], rel=0.02)
    assert program(tmp_path, monkeypatch) == 0
    table = capsys.readouterr().out
    assert table.count("\n") == len(tensors) + 2 + 1 + 6
