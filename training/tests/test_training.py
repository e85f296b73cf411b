"""The loop: it learns, it goes on exactly where it was, and it refuses what it cannot do with one message."""
import json
import signal
import subprocess
import sys
import time

import pytest
import small_world
import torch

from egofocus_training import checkpoint
from egofocus_training.config import load_config, parse_config
from egofocus_training.errors import BAD_FILE, CONFIGURATION, DIVERGED, FILE, USAGE, TrainingError
from egofocus_training.dataset import WindowDataset
from egofocus_training.evaluate import load_network
from egofocus_training.integer_model import IntegerModel
from egofocus_training.machine import only_run
from egofocus_training.mean_weights import mean
from egofocus_training.overfit import overfit
from egofocus_training.quantisation import is_quantised
from egofocus_training.samples import find_shards
from egofocus_training.trainer import Trainer, learning_rate

CONFIG = """
[data]
train = ["shards"]
{data}
[input]
hypotheses = 16
span_px = 16.0
maps = ["gradient:3", "squares:7"]
[network]
widths = [16, 16, 16]
blocks = [0, 0, 0]
up_blocks = [0, 1]
refine_width = 8
refine_dilations = [1]
{network}
[augment]
crop = [48, 64]
[train]
seed = 5
batch = 2
steps = 6
workers = {workers}
warmup_steps = 2
checkpoint_every_s = 0.0
{train}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("training")
    small_world.write_shards(path / "shards", [small_world.varied_records(8), small_world.varied_records(8, 100)])
    return path


def configured(folder, data="", network="", train="", workers=0):
    path = folder / "config.toml"
    path.write_text(CONFIG.format(data=data, network=network, train=train, workers=workers))
    return load_config(path)


def trained(config, until, resume=None, device_threads=1):
    trainer = Trainer(config, lambda: find_shards(config.data.train))
    if resume:
        trainer.resume(resume)
    terms = []
    trainer.run(until, lambda t: terms.append(t))
    return trainer, terms


def refusal(call):
    with pytest.raises(TrainingError) as caught:
        call()
    return caught.value.exit_code, str(caught.value)


def test_six_steps_are_three_and_three(folder, tmp_path):
    whole, terms = trained(configured(folder), 6)
    first, _ = trained(configured(folder), 3)
    first.save(tmp_path)
    second, rest = trained(configured(folder, workers=1), 6, tmp_path / "checkpoint.pt")
    assert rest == terms[3:]
    assert len({t["loss"] for t in terms}) == 6
    assert (second.step, second.epoch, second.batch) == (whole.step, whole.epoch, whole.batch) == (6, 0, 6)
    for name, tensor in whole.network.state_dict().items():
        assert torch.equal(tensor, second.network.state_dict()[name]), name
    for name, tensor in whole.average.network.state_dict().items():
        assert torch.equal(tensor, second.average.network.state_dict()[name]), name


@pytest.mark.parametrize("stop", [2, 4, 5])  # before, at and after the step where rounding begins
def test_rounding_takes_part_in_the_last_steps_wherever_a_run_is_stopped(folder, tmp_path, stop):
    train = "[quantise]\nlast_steps = 2\ncalibration_batches = 2"
    whole, terms = trained(configured(folder, train=train), 6)
    assert is_quantised(whole.network) and is_quantised(whole.average.network)
    first, _ = trained(configured(folder, train=train), stop)
    assert is_quantised(first.network) == (stop > 4)
    first.save(tmp_path)
    second, rest = trained(configured(folder, train=train), 6, tmp_path / "checkpoint.pt")
    assert rest == terms[stop:]
    for name, tensor in whole.average.network.state_dict().items():
        assert torch.equal(tensor, second.average.network.state_dict()[name]), name
    second.save(tmp_path)
    network = load_network(tmp_path / "weights.pt", second.config)
    assert is_quantised(network)
    IntegerModel(network)


def test_order_is_a_permutation_that_the_seed_decides(folder):
    dataset = WindowDataset(find_shards([str(folder / "shards")]), configured(folder))
    assert sorted(dataset.order(0)) == list(range(16))
    assert dataset.order(0).tolist() != dataset.order(1).tolist()
    again = WindowDataset(find_shards([str(folder / "shards")]), configured(folder))
    assert again.order(1).tolist() == dataset.order(1).tolist()
    a, b = dataset[(0, 3)], again[(0, 3)]
    assert all((a[name] == b[name]).all() for name in a)
    assert not (dataset[(1, 3)]["focus"] == a["focus"]).all()


def test_an_epoch_ends_and_the_next_begins(folder):
    trainer, _ = trained(configured(folder, train="log_every = 1"), 9)
    assert (trainer.epoch, trainer.batch, trainer.step) == (1, 1, 9)


def test_learning_rate():
    train = parse_config("[train]\nsteps = 110\nwarmup_steps = 10\nlearning_rate = 1.0", "x").train
    assert [learning_rate(s, train) for s in (0, 9, 10, 60, 110)] == pytest.approx([0.1, 1, 1, 0.5, 0])


def test_it_learns_a_few_samples(folder):
    config = configured(folder, train="learning_rate = 5e-3\nema = 0.9")
    config.quantise.last_steps = 120  # of a longer training: here it learns in floats
    rows, loss = overfit(config, 4, 120)
    got = {(r["method"], r["set"]): r for r in rows if r["family"] == "overall"}
    assert got["network", "all"]["images"] == 4
    assert got["network", "all"]["abs_rel"] < 0.03
    assert got["network", "all"]["d1"] > 0.97
    assert got["median", "all"]["abs_rel"] > 0.03  # what no use of the input would reach


def test_nan_stops_before_anything_is_spoilt(folder):
    config = configured(folder)
    trainer = Trainer(config, lambda: find_shards(config.data.train))
    before = {name: t.clone() for name, t in trainer.network.state_dict().items() if "running" not in name and "num_" not in name}
    with torch.no_grad():
        trainer.network.aggregation.head.bias.fill_(float("nan"))
    code, message = refusal(lambda: trainer.run(6, lambda t: None))
    assert code == DIVERGED and "step 0" in message and "smaller learning_rate" in message
    del before["aggregation.head.bias"]
    assert all(torch.equal(t, trainer.network.state_dict()[name]) for name, t in before.items())


@pytest.mark.parametrize("workers", [0, 1])
def test_a_damaged_sample_is_named_with_its_exit_code(folder, tmp_path, workers):
    records = small_world.varied_records(4)
    records[2] = records[2][:-1]
    small_world.write_shards(tmp_path / "shards", [records])
    config = configured(tmp_path, workers=workers)
    code, message = refusal(lambda: trained(config, 4))
    assert code == BAD_FILE and "shard_000000.egs, sample 2" in message and "citysim samples" in message


def test_checkpoints_that_are_none_or_another_networks(folder, tmp_path):
    trainer, _ = trained(configured(folder), 1)
    trainer.save(tmp_path)
    other = configured(folder, network="ihca_blocks = 1")
    code, message = refusal(lambda: Trainer(other, trainer.find_paths).resume(tmp_path / "checkpoint.pt"))
    assert code == CONFIGURATION and "[network] ihca_blocks is 0 there and 1" in message
    data = (tmp_path / "checkpoint.pt").read_bytes()
    (tmp_path / "cut.pt").write_bytes(data[:len(data) // 2])
    assert refusal(lambda: checkpoint.read(tmp_path / "cut.pt"))[0] == BAD_FILE
    torch.save({"a": 1}, tmp_path / "alien.pt")
    assert refusal(lambda: checkpoint.read(tmp_path / "alien.pt"))[0] == BAD_FILE
    assert refusal(lambda: checkpoint.read(tmp_path / "none.pt"))[0] == FILE


def test_a_training_begins_with_given_weights(folder, tmp_path):
    first, _ = trained(configured(folder), 2)
    first.save(tmp_path)
    config = configured(folder, network="regression = 'expectation'", train=f'start = "{tmp_path / "weights.pt"}"')
    begun = Trainer(config, first.find_paths)
    assert begun.step == 0
    for name, tensor in first.average.network.state_dict().items():
        assert torch.equal(tensor, begun.network.state_dict()[name]) and torch.equal(tensor, begun.average.network.state_dict()[name])
    other = configured(folder, network="ihca_blocks = 1", train=f'start = "{tmp_path / "weights.pt"}"')
    code, message = refusal(lambda: Trainer(other, first.find_paths))
    assert code == CONFIGURATION and "weights.pt" in message


def test_two_processes_do_not_train_in_one_folder(tmp_path):
    first = subprocess.Popen([sys.executable, "-c", "import pathlib, sys, time; from egofocus_training.machine import only_run; "
                              "lock = only_run(pathlib.Path(sys.argv[1])); print('mine', flush=True); time.sleep(60)", str(tmp_path)],
                             stdout=subprocess.PIPE, text=True)
    try:
        assert first.stdout.readline() == "mine\n"
        code, message = refusal(lambda: only_run(tmp_path))
        assert code == USAGE and "another process trains there" in message
    finally:
        first.kill()
        first.wait()
    only_run(tmp_path).close()
    assert refusal(lambda: only_run(tmp_path / "none"))[0] == FILE


def test_too_little_disk(tmp_path, monkeypatch):
    monkeypatch.setattr(checkpoint, "free_bytes", lambda path: 5 << 20)
    code, message = refusal(lambda: checkpoint.write(tmp_path / "c.pt", {"w": torch.zeros(1 << 20)}))
    assert code == FILE and "too little disk: 5 MiB are left, a checkpoint takes 4 MiB" in message
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("text, words", [
    ("[train]\nstepz = 3", "unknown key `stepz` in [train]. Known: batch,"),
    ("[trian]\nsteps = 3", "unknown section [trian]"),
    ("[train]\nsteps = 'many'", "[train] steps = 'many' is not a int"),
    ("[train]\nbf16 = 1", "is not a bool"),
    ("[input]\nhypotheses = 36", "a multiple of 8"),
    ("[input]\nmaps = ['gradient:4']", "`gradient:4` is not"),
    ("[input]\nmaps = ['gradient:1', 'gradient:3', 'gradient:5', 'gradient:7', 'squares:1', 'squares:3', 'squares:5', 'squares:7', 'gradient_x:1']",
     "maps: 1 to 8"),
    ("[input]\nfloor_events = 0.0505", "floor_events: 0.02 to 2 in whole thousandths"),
    ("[input]\nfloor_events = 0.01", "floor_events: 0.02 to 2 in whole thousandths"),
    ("[input]\nfloor_noise = 8.001", "floor_noise: 0.1 to 8 in whole thousandths"),
    ("[input]\nfloor_noise = nan", "floor_noise: 0.1 to 8 in whole thousandths"),
    ("[augment]\ncrop = [100, 208]", "multiples of 16"),
    ("[data]\nfamilies = ['town9']", "no family is called town9"),
    ("[quantise]\nlast_steps = 20000", "last_steps: 0 to [train] steps"),
    ("[network]\norder = 'published'\n[quantise]\nlast_steps = 2", "no integer form"),
    ("steps", "is not TOML"),
])
def test_wrong_configs(text, words):
    code, message = refusal(lambda: parse_config(text, "c.toml"))
    assert code == CONFIGURATION and message.startswith("c.toml: ") and words in message


def test_the_programs(folder, tmp_path):
    """Train, refuse, resume, evaluate from the command line."""
    configured(folder, data="hold_out_every = 2\nvalidation_samples = 3", train="log_every = 2")
    config, out = str(folder / "config.toml"), str(tmp_path / "out")

    def program(name, *arguments):
        return subprocess.run([sys.executable, "-m", f"egofocus_training.{name}", *arguments], capture_output=True, text=True,
                              check=False)

    done = program("train", "--config", config, "--out", out, "--stop-after-s", "0")
    assert done.returncode == 0, done.stderr
    again = program("train", "--config", config, "--out", out)
    assert again.returncode == 2 and "--resume" in again.stderr and again.stderr.count("\n") == 1
    done = program("train", "--config", config, "--out", out, "--resume")
    assert done.returncode == 0, done.stderr
    entries = [json.loads(line) for line in open(tmp_path / "out" / "log.jsonl")]
    assert entries[-1]["step"] == 6 and 0 <= entries[-1]["d1_all"] <= 1
    assert sum("loss" in e and e["step"] == 4 for e in entries) == 1
    assert (tmp_path / "out" / "curves.png").read_bytes()[1:4] == b"PNG"
    done = program("evaluate", "--config", config, "--weights", out + "/weights.pt", "--json")
    assert done.returncode == 0, done.stderr
    rows = json.loads(done.stdout)["rows"]
    assert {r["method"] for r in rows} == {"network", "argmax", "sgm", "median"}
    for wrong in (("evaluate", "--config", config, "--samples", "0"), ("macs", "--config", config, "--size", "big"),
                  ("recordings", "--config", config), ("overfit", "--config", config, "--steps", "0")):
        refused = program(*wrong)
        assert refused.returncode in (2, 5) and refused.stderr.startswith("error: ") and refused.stderr.count("\n") == 1
    table = program("macs", "--config", config, "--json")
    assert json.loads(table.stdout)["macs"] == sum(layer["macs"] for layer in json.loads(table.stdout)["layers"])
    running = subprocess.Popen([sys.executable, "-m", "egofocus_training.train", "--config", config, "--out", out + "2"],
                               stderr=subprocess.PIPE, text=True)
    log = tmp_path / "out2" / "log.jsonl"
    while running.poll() is None and not log.exists():
        time.sleep(0.05)
    running.send_signal(signal.SIGTERM)
    stderr = running.communicate()[1]
    if running.returncode != 0:  # it may have been quicker
        assert running.returncode == 130 and "--resume goes on" in stderr
    assert (tmp_path / "out2" / "checkpoint.pt").exists()
    missing = program("train", "--config", str(tmp_path / "none.toml"), "--out", out)
    assert missing.returncode == 3 and "none.toml" in missing.stderr


def test_the_mean_of_trainings_is_that_of_their_numbers(tmp_path):
    facts = {"network": {"widths": [16]}}
    for name, value, count, extra in (("a.pt", 1.0, 3, {}), ("b.pt", 2.0, 5, {}), ("c.pt", 2.0, 5, {"more": torch.zeros(1)})):
        network = {"w": torch.full((2, 3), value), "count": torch.tensor(count), **extra}
        checkpoint.write(tmp_path / name, {"network_facts": facts, "step": 7, "quantised": True, "network": network})
    both = mean([tmp_path / "a.pt", tmp_path / "b.pt"])
    assert both["network"]["w"].unique().tolist() == [1.5]
    assert both["network"]["count"].item() == 5  # no mean of what is no measure
    assert both["quantised"] and both["network_facts"] == facts
    code, message = refusal(lambda: mean([tmp_path / "a.pt", tmp_path / "c.pt"]))
    assert code == CONFIGURATION and "a.pt" in message and "other tensors" in message
