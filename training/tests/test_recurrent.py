"""The baseline on voxel grids: its input by hand, its recurrence by hand, its cost, and that it learns and goes on as the others."""
import math
import pathlib
import tomllib

import numpy as np
import pytest
import small_world
import torch
from PIL import Image

from egofocus_training import library, maps
from egofocus_training.config import RecurrentConfig, load_config, parse_config
from egofocus_training.errors import CONFIGURATION, TrainingError
from egofocus_training.evaluate import load_network
from egofocus_training.macs import example_input, layer_table, totals
from egofocus_training.model.build import network_of
from egofocus_training.model.recurrent import ConvGru, step_px
from egofocus_training.overfit import overfit
from egofocus_training.samples import Camera, Sample, find_shards, parse_sample
from egofocus_training.trainer import Trainer
from egofocus_training.voxels import motion_of_slices, rays_of, voxel_bytes, voxel_grids
from egofocus_training.windows import recording_facts, sample_facts

ROOT = pathlib.Path(__file__).resolve().parents[2]
PLANES = ROOT / "fixtures" / "planes"
RECURRENT = """[recurrent]
slices = 2
bins = 3
stem = 8
widths = [16, 16, 16]
refine_width = 8
refine_dilations = [1]
"""
CONFIG = small_world.CONFIG.replace("[network]", '[network]\norder = "recurrent"').replace("hold_out_every = 2", "")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("recurrent")
    small_world.write_shards(path / "shards", [small_world.varied_records(8), small_world.varied_records(8, 100)])
    return path


def configured(folder, train="", workers=0):
    path = folder / "config.toml"
    path.write_text(CONFIG.replace("workers = 0", f"workers = {workers}").format(train + "\n" + RECURRENT))
    return load_config(path)


def test_voxel_grid_by_hand():
    #                 too old; slice 0: bin 0, half way, bin 1, half way; slice 1: bin 0, its end; outside the grid
    t_us = np.array([-9, -8, -7, -6, -5, -4, 0, -1], np.int32)
    cell = np.array([0, 0, 1, 1, 0, 1, 1, -1])
    polarity = np.array([1, 1, 1, 0, 0, 1, 0, 1], np.uint8)
    grid = voxel_grids(t_us, cell, polarity, -8, slices=2, bins=3, pixels=2)
    assert grid.dtype == np.float32
    assert grid.tolist() == [[[1, 0.5], [-0.5, 0.5 - 1], [-0.5, 0]], [[0, 1], [0, 0], [0, -1]]]


def test_bytes_are_in_steps_of_a_sixteenth_of_the_deviation():
    grid = np.array([0, 1, -1, 0, 7, -0.5], np.float32)
    sd = math.sqrt((1 + 1 + 49 + 0.25) / 4)
    assert voxel_bytes(grid).dtype == np.int8
    assert voxel_bytes(grid).tolist() == [0, round(16 / sd), -round(16 / sd), 0, round(112 / sd), -round(8 / sd)]
    assert voxel_bytes(np.zeros(3, np.float32)).tolist() == [0, 0, 0]
    assert voxel_bytes(np.array([1.0] * 999 + [1000]))[-1] == 127


def test_motion_and_rays_by_hand():
    t_us = np.array([-200_000, 0], np.int32)
    velocity, rate = np.array([[1.0, 2, 3], [2, 2, 3]]), np.array([[0.0, 0.1, 0], [0, 0.1, 0]])
    motion = motion_of_slices(t_us, velocity, rate, -200_000, 2, step_per_m=0.1, focal_px=100.0)
    logs = [math.log(0.1), math.log(0.2)]
    assert motion[0].tolist() == pytest.approx([2 * 1.25, 4, 6, 0, 0.125, 0, *logs])
    assert motion[1].tolist() == pytest.approx([2 * 1.75, 4, 6, 0, 0.125, 0, *logs])
    rays = rays_of((5, 2, 2.0, 1.0, 1.5, 0.5), 2)
    assert rays.shape == (2, 1, 3) and rays[0, 0].tolist() == [-0.5, 0.5, 1.5] and rays[1, 0].tolist() == [0, 0, 0]
    moved = step_px(torch.tensor([[3.0, 0, 2, 0, 0, 0, 0, 0]]), torch.tensor([[[[0.0, 1.5]], [[2.0, 0.0]]]]))
    assert moved.flatten().tolist() == [5, 0]  # |(3, -4)|, and the focus of expansion


def plumb_bob(x, y, k):
    r2 = x * x + y * y
    radial = 1 + k[0] * r2 + k[1] * r2 ** 2 + k[4] * r2 ** 3
    return (x * radial + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x), y * radial + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y)


def test_events_lie_where_their_undistorted_rays_do():
    k, grid = [-0.25, 0.06, 0.001, -0.0005, 0.0], (96, 80, 70.0, 72.0, 46.0, 41.0)
    table = library.stack.grid_pixels(camera=grid, distortion=1, coefficients=k)
    y, x = np.nonzero(table >= 0)
    assert 0.7 * table.size < y.size < 0.9 * table.size  # a barrel sees beyond the grid
    u, v = table[y, x] % 96, table[y, x] // 96
    back_x, back_y = plumb_bob((u - 46.0) / 70, (v - 41.0) / 72, k)
    assert np.abs(70 * back_x + 46 - x).max() < 0.75 and np.abs(72 * back_y + 41 - y).max() < 0.75  # half a pixel, and its corner
    crop = library.stack.grid_pixels(camera=grid, distortion=1, coefficients=k, crop=(10, 20, 32, 48))
    inside = (table >= 0) & (table % 96 >= 10) & (table % 96 < 42) & (table // 96 >= 20) & (table // 96 < 68)
    assert np.array_equal(crop, np.where(inside, (table // 96 - 20) * 32 + table % 96 - 10, -1))


def test_a_samples_window(folder):
    config = configured(folder)
    sample = parse_sample(small_world.record(2.0), "test")
    facts = sample_facts(sample, config, crop=(16, 8, 48, 64))
    assert facts["slices"].shape == (2, 3, 64, 48) and facts["slices"].dtype == np.int8
    assert facts["motion"].shape == (2, 8) and facts["rays"].shape == (2, 32, 24)
    inside = (sample.t_us >= facts["begin_us"]) & (sample.x >= 16) & (sample.x < 64) & (sample.y >= 8) & (sample.y < 72)
    hit = np.zeros((64, 48), bool)
    hit[sample.y[inside] - 8, sample.x[inside] - 16] = True
    seen = facts["slices"].any(axis=(0, 1))
    assert not seen[~hit].any() and seen[hit].mean() > 0.95  # opposite signs may cancel
    # 1 m/s for as long as the window lasts, in px per step of the ladder
    assert facts["motion"][:, 0] == pytest.approx(small_world.FOCAL * -facts["begin_us"] * 1e-6 * facts["step_per_m"])
    assert facts["rays"][0, 0, 0] == pytest.approx((16.5 - 47.5) / small_world.FOCAL)
    still = parse_sample(small_world.record(2.0), "test")
    still.velocity_m_s[:] = 0
    assert not sample_facts(still, config)["has_stack"]


def test_a_recording_and_a_sample_of_it_look_the_same(folder):
    config = configured(folder)
    ladder = ("parallax", 16, 0.95, 16.0, 5.0)
    recording = library.stack.Recording(str(PLANES), "odometry", ladder)
    facts = recording_facts(recording, 700_000, config)
    t_us, x, y, polarity = recording.events(700_000)
    width, height, *more = facts["grid"]
    coefficients = tomllib.loads((PLANES / "camera.toml").read_text())["camera"]["coefficients"]
    sample = Sample(0, 0, "room", False, Camera(width, height, *more, 1, np.array(coefficients)), 0.95, 200_000, *recording.motion(700_000),
                    t_us, x, y, polarity, np.ones((height, width), np.float32), np.zeros((height, width), bool))
    again = sample_facts(sample, config)
    assert facts["begin_us"] == again["begin_us"] and facts["slices"].any()
    assert np.array_equal(facts["slices"], again["slices"]) and np.array_equal(facts["rays"], again["rays"])
    # 20 samples of motion in place of all that was measured: the ladder's step is another in the fourth digit.
    assert np.allclose(facts["motion"], again["motion"], rtol=1e-3, atol=1e-6)


def test_gru_by_hand():
    gru = ConvGru(1)
    with torch.no_grad():
        gru.of_input.weight[:] = torch.tensor([0.5, -1.0, 2.0]).reshape(3, 1, 1, 1)
        gru.of_input.bias[:] = torch.tensor([0.1, 0.2, 0.3])
        gru.of_state.weight.zero_()
        gru.of_state.weight[:, 0, 1, 1] = torch.tensor([1.0, -2.0, 3.0])
    states = gru(torch.tensor([0.4, -0.6]).reshape(2, 1, 1, 1, 1)).flatten().tolist()

    def sigmoid(v):
        return 1 / (1 + math.exp(-v))

    first = (1 - sigmoid(0.5 * 0.4 + 0.1)) * math.tanh(2 * 0.4 + 0.3)
    keep = sigmoid(-0.5 * 0.6 + 0.1 + first)
    reset = sigmoid(0.6 + 0.2 - 2 * first)
    second = (1 - keep) * math.tanh(-2 * 0.6 + 0.3 + reset * 3 * first) + keep * first
    assert states == pytest.approx([first, second], abs=1e-6)


@pytest.mark.parametrize("size", [(346, 260), (208, 160)])
def test_shapes(size):
    config = parse_config('[input]\nhypotheses = 16\n[network]\norder = "recurrent"\n' + RECURRENT, "test")
    network = network_of(config).train()
    prediction = network(example_input(config, *size, batch=2))
    width, height = size
    assert prediction.scores.shape == (2, 16, -(-height // 4), -(-width // 4))
    assert prediction.coarse.shape == (2, 16, -(-height // 8), -(-width // 8))
    assert prediction.index.shape == (2, -(-height // 2), -(-width // 2))
    assert prediction.confidence.shape == prediction.index_4.shape == (2, -(-height // 4), -(-width // 4))
    (prediction.scores.sum() + prediction.index.sum() + prediction.coarse.sum()).backward()
    assert [name for name, p in network.named_parameters() if p.grad is None] == []


def test_each_slice_and_their_order_matter():
    torch.manual_seed(3)
    config = parse_config('[input]\nhypotheses = 16\n[network]\norder = "recurrent"\n' + RECURRENT, "test")
    network = network_of(config).eval()
    inputs = example_input(config, 64, 48)
    inputs["slices"] = torch.randint(-64, 64, inputs["slices"].shape, dtype=torch.int8)
    scores = network(inputs).scores
    assert not torch.allclose(network(inputs | {"slices": inputs["slices"].flip(1)}).scores, scores, atol=1e-4)
    changed = inputs["slices"].clone()
    changed[:, 0] = 0
    assert not torch.allclose(network(inputs | {"slices": changed}).scores, scores, atol=1e-4)
    assert not torch.allclose(network(inputs | {"motion": inputs["motion"] + 1}).scores, scores, atol=1e-4)
    assert network(inputs | {"used": torch.tensor([8])}).index.max() <= 7


def test_it_costs_what_base_costs_and_is_trained_alike():
    base, recurrent = (load_config(ROOT / "training" / "configs" / f"{name}.toml") for name in ("base", "recurrent"))
    rows = layer_table(recurrent, 346, 260)
    mine, theirs = totals(rows)["macs"], totals(layer_table(base, 346, 260))["macs"]
    assert abs(mine / theirs - 1) < 0.03
    by_name = {r["layer"]: r for r in rows}
    assert by_name["stem.0"]["macs"] == 4 * 130 * 173 * 9 * 5 * 16
    assert by_name["at_4.gru.of_state"]["macs"] == 3 * 65 * 87 * 9 * 28 * 84  # not before the first slice
    assert by_name["at_4.gru.of_state"]["weight_bytes"] == 9 * 28 * 84 + 8 * 84  # once
    assert recurrent.recurrent == RecurrentConfig()
    for section in ("data", "input", "augment", "loss", "train"):
        assert getattr(recurrent, section) == getattr(base, section), section


def trained(config, until, resume=None):
    trainer = Trainer(config, lambda: find_shards(config.data.train))
    if resume:
        trainer.resume(resume)
    terms = []
    trainer.run(until, lambda t: terms.append(t))
    return trainer, terms


def test_four_steps_are_two_and_two(folder, tmp_path):
    whole, terms = trained(configured(folder), 4)
    first, _ = trained(configured(folder), 2)
    first.save(tmp_path)
    second, rest = trained(configured(folder, workers=1), 4, tmp_path / "checkpoint.pt")
    assert rest == terms[2:] and len({t["loss"] for t in terms}) == 4
    assert set(terms[0]) == {"distribution", "index", "log_depth", "refined", "coarse", "loss"}
    for name, tensor in whole.average.network.state_dict().items():
        assert torch.equal(tensor, second.average.network.state_dict()[name]), name


def test_it_learns_a_few_samples(folder):
    config = configured(folder, train="learning_rate = 1e-2\nema = 0.9")
    config.train.batch = 4  # of two windows batch norm would say too much
    rows, _ = overfit(config, 4, 60)
    got = {r["method"]: r for r in rows if r["family"] == "overall" and r["set"] == "all"}
    assert got["network"]["images"] == 4 and got["network"]["abs_rel"] < 0.03 < got["median"]["abs_rel"]


def test_maps_of_a_recording_and_what_is_refused(folder, tmp_path, monkeypatch, capsys):
    config = configured(folder)
    Trainer(config, lambda: find_shards(config.data.train)).save(tmp_path)
    arguments = ["maps", "--config", str(folder / "config.toml"), "--weights", str(tmp_path / "weights.pt"), "--out", str(tmp_path / "out")]
    monkeypatch.setattr("sys.argv", [*arguments, str(PLANES)])
    assert maps.main() == 0
    found = {path.name for path in (tmp_path / "out" / "planes").glob("*.png")}
    assert found == {path.name for path in (PLANES / "depth").glob("*.png")} and f"{len(found)} maps" in capsys.readouterr().out
    assert len(np.unique(np.asarray(Image.open(tmp_path / "out" / "planes" / "000000700000.png")))) > 3
    monkeypatch.setattr("sys.argv", [*arguments, "--integer", str(PLANES)])
    with pytest.raises(TrainingError, match="has no integers") as caught:
        maps.main()
    assert caught.value.exit_code == CONFIGURATION
    config.recurrent.bins = 5
    with pytest.raises(TrainingError, match=r"\[recurrent\] bins is 3 there and 5"):
        load_network(tmp_path / "weights.pt", config)


@pytest.mark.parametrize("text, words", [
    ("[recurrent]\nbins = 1", "slices: 1 to 32; bins: 2 to 32"),
    ("[recurrent]\nwidths = [16, 16]", "the three widths"),
    ("[recurrent]\nwidths = [16, 16, 1.5]", "the three widths"),
    ("[recurrent]\nrefine_dilations = [0]", "refine_dilations"),
    ("[network]\norder = 'recurrent'\n[quantise]\nlast_steps = 2", "the recurrent order has no integer form"),
    ("[network]\norder = 'other'", "focus_first, published or recurrent"),
])
def test_wrong_configs(text, words):
    with pytest.raises(TrainingError) as caught:
        parse_config(text, "c.toml")
    assert caught.value.exit_code == CONFIGURATION and words in str(caught.value)
