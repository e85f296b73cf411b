"""Networks side by side: what a plan may say, what is trained, and what is not trained again."""
import json

import pytest
import small_world

from egofocus_training import compare
from egofocus_training.errors import CONFIGURATION, FILE, TrainingError

PLAN = """
base = "base.toml"
seeds = [1, 2]
[all.train]
steps = 2
[all.data]
validation_samples = 3
[variant.plain]
[variant.with_ihca]
network = { ihca_blocks = 1 }
"""


@pytest.fixture()
def folder(tmp_path):
    small_world.write_shards(tmp_path / "shards", [small_world.varied_records(4), small_world.varied_records(4, 100)])
    (tmp_path / "base.toml").write_text(small_world.CONFIG.format(""))
    (tmp_path / "plan.toml").write_text(PLAN)
    return tmp_path


def run(folder, monkeypatch, capsys, *options):
    monkeypatch.setattr("sys.argv", ["compare", "--plan", str(folder / "plan.toml"), "--out", str(folder / "out"), *options])
    assert compare.main() == 0
    return capsys.readouterr()


def test_each_variant_and_seed_is_trained_once(folder, monkeypatch, capsys):
    rows = json.loads(run(folder, monkeypatch, capsys, "--json").out)
    assert [r["variant"] for r in rows] == ["plain", "with_ihca"]
    assert [(r["seeds"], r["samples"]) for r in rows] == [(2, 4), (2, 4)] and rows[0]["mmac"] < rows[1]["mmac"]
    files = {p.name: json.loads(p.read_text()) for p in (folder / "out").iterdir()}
    assert sorted(files) == ["plain_1.json", "plain_2.json", "with_ihca_1.json", "with_ihca_2.json"]
    errors = [files[f"plain_{seed}.json"]["all"]["abs_rel"] for seed in (1, 2)]
    assert errors[0] != errors[1]  # another seed is another training
    mean, deviation = rows[0]["abs_rel_all"]
    assert mean == pytest.approx(sum(errors) / 2) and deviation == pytest.approx(abs(errors[0] - errors[1]) / 2 ** 0.5)

    (folder / "out" / "plain_2.json").unlink()
    monkeypatch.setattr(compare, "train_once", lambda *_: pytest.fail("trained again") if _[1] == 1 else files["plain_2.json"])
    again = run(folder, monkeypatch, capsys)
    assert "with_ihca" in again.out and again.out.count("+-") == 12
    assert again.err.count("d1") == 1


@pytest.mark.parametrize("old, new, words", [
    ("seeds = [1, 2]", "seeds = []", "seeds: a list"),
    ("ihca_blocks", "ihca_blockz", "[variant.with_ihca]: unknown key `ihca_blockz` in [network]"),
    ('base = "base.toml"', "", "wants base"),
    ("[variant.plain]\n[variant.with_ihca]\nnetwork = { ihca_blocks = 1 }", "", "names no [variant.NAME]"),
    ("network = { ihca_blocks = 1 }", "network = 3", "a table is wanted"),
    ("[variant.plain]", "[variant.plain", "is not TOML"),
])
def test_wrong_plans(folder, old, new, words):
    assert old in PLAN
    (folder / "plan.toml").write_text(PLAN.replace(old, new))
    with pytest.raises(TrainingError) as caught:
        compare.read_plan(folder / "plan.toml")
    assert caught.value.exit_code == CONFIGURATION and words in str(caught.value)


def test_missing_files_and_another_plans_results(folder, monkeypatch, capsys):
    with pytest.raises(TrainingError) as caught:
        compare.read_plan(folder / "none.toml")
    assert caught.value.exit_code == FILE
    (folder / "out").mkdir()
    (folder / "out" / "plain_1.json").write_text(json.dumps({"facts": {}}))
    with pytest.raises(TrainingError) as caught:
        run(folder, monkeypatch, capsys)
    assert caught.value.exit_code == CONFIGURATION and "another network" in str(caught.value)
