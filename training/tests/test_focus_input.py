"""The network's input is the library's: its bytes are those of the integers written a second time, and near the formulas."""
import itertools
import subprocess

import numpy as np
import pytest
import small_world
from focus_reference import cell_sums, float_input, integer_input, support
from test_recordings import PLANES
from test_samples import citysim

from egofocus_training.config import InputConfig
from egofocus_training.focus_input import binding_maps, context_channels
from egofocus_training.library import stack
from egofocus_training.samples import Shard, parse_sample
from egofocus_training.units import ZERO
from egofocus_training.windows import ladder_of, stack_sample

WANTED = ["cells", "focus", "context"]
OTHERS = [
    InputConfig(),
    InputConfig(hypotheses=32, span_px=32.0, maps=["gradient:3", "gradient:7", "squares:3", "squares:7"]),
    InputConfig(floor_events=0.02, floor_noise=0.1, maps=["gradient_x:1", "gradient_y:5", "squares:1", "squares:5"]),
    InputConfig(floor_events=2.0, floor_noise=8.0, maps=["gradient:5", "gradient_y:7", "gradient_x:3"]),
    InputConfig(hypotheses=64, floor_events=0.333, floor_noise=0.777, maps=["squares:7"]),
]


def require_same(facts, config):
    """focus and context of facts against the integers of the reference; the cells that they rest on."""
    cells = facts["cells"][:, :facts["hypotheses"]]
    focus, context = integer_input(cells, facts, config, config.hypotheses)
    assert focus.shape == facts["focus"].shape and facts["context"].shape[0] == context_channels(config)
    assert np.array_equal(facts["focus"], focus) and np.array_equal(facts["context"], context)
    return cells


@pytest.fixture(scope="module")
def town_shard(tmp_path_factory):
    if citysim() is None:
        pytest.skip("citysim was not built")
    folder = tmp_path_factory.mktemp("samples")
    subprocess.run([citysim(), "samples", "--out", str(folder), "--count", "1", "--seed", "3"], check=True, capture_output=True)
    return Shard(folder / "shard_000000.egs")


def test_windows_of_several_families(town_shard):
    """Each byte is the reference's; next to none is further than one step from the formulas, and few differ at all."""
    config, families, windows = InputConfig(), set(), 0
    differ, unrounded = {"focus": [], "context": []}, {"focus": 0.0, "context": 0.0}
    for i in range(0, len(town_shard), 4):
        sample = town_shard[i]
        facts = stack_sample(sample, config, WANTED)
        if not facts["has_stack"]:
            continue
        cells = require_same(facts, config)
        windows += 1
        families.add(sample.family)
        used = facts["hypotheses"]
        for name, meant in zip(("focus", "context"), float_input(cells, facts, config, config.hypotheses)):
            part = slice(0, used if name == "focus" else None)
            got, meant = facts[name][part].astype(int) - ZERO, np.clip(meant[part], -64, 63)
            error = np.abs(got - np.rint(meant))
            assert np.mean(error > 1) < 1e-4  # beside a pixel that fires all the time, where the ratio saturates
            differ[name].append(error.mean())
            unrounded[name] = max(unrounded[name], np.abs(got - meant)[error <= 1].max())
    print(f"\n{windows} windows of {', '.join(sorted(families))}:",
          "; ".join(f"{name}: {100 * np.mean(differ[name]):.2f} % differ by 1 step, unrounded at most {unrounded[name]:.2f}" for name in differ))
    assert windows >= 8 and len(families) >= 3
    assert np.mean(differ["focus"]) < 0.01 and np.mean(differ["context"]) < 0.05


@pytest.mark.parametrize("config", OTHERS)
def test_other_maps_and_floors(config):
    sample = parse_sample(small_world.record(2.0, near=(20, 50, 1.1)), "test")
    for crop in ((0, 0, 0, 0), (3, 5, 61, 38)):
        facts = stack_sample(sample, config, WANTED, crop)
        assert facts["has_stack"]
        require_same(facts, config)


def test_a_recording():
    config = InputConfig(hypotheses=32)
    recording = stack.Recording(PLANES, "odometry", ladder_of(config, 0.95))
    seen = 0
    for t_us in range(300_000, 1_900_000, 200_000):
        facts = recording.tick(t_us, WANTED, binding_maps(config))
        if facts["has_stack"]:
            seen += 1
            require_same(facts, config)
    assert seen >= 5
    with pytest.raises(stack.StackError, match="need the network's maps"):
        stack.Recording(PLANES, "odometry").tick(700_000, ["focus"])


def adversarial(name, used, height, width):
    random = np.random.default_rng(3)
    planes = np.zeros((used, height, width), np.uint8)
    if name == "one event":
        planes[used // 2, height // 2, width // 2] = 1
    elif name == "full":
        planes[:] = 255
    elif name == "saturated":  # each cell's energies beyond 65535
        planes[:, (np.indices((height, width)) // 2).sum(axis=0) % 2 == 0] = 255
    elif name == "noise":
        planes[:] = random.integers(0, 256, planes.shape)
    elif name == "hot pixels":
        planes[:] = random.random(planes.shape) < 0.05
        planes[0, random.random((height, width)) < 0.01] = 255
    elif name == "one hypothesis":
        planes[used // 2] = random.integers(0, 256, (height, width))
    return planes


@pytest.mark.parametrize("name", ["zeros", "one event", "full", "saturated", "noise", "hot pixels", "one hypothesis"])
@pytest.mark.parametrize("used, depth", [(1, 32), (2, 8), (8, 48), (32, 32), (64, 64), (3, 7)])
def test_adversarial_planes(name, used, depth):
    grid = (37, 30, 80.0, 90.0, 18.5, 14.25)
    planes = adversarial(name, used, 30, 37)
    cells = cell_sums(planes)
    assert name != "saturated" or (cells[:3] == 65535).mean() > 0.5
    motions = itertools.cycle([((-0.2, 0.1, 0.4), 0.125), ((0.0, 0.0, 0.0), 1.0), ((90.0, -0.01, 0.0), 3.0), ((1e-9, 40.0, -90.0), 0.5),
                               ((float("nan"), 1e300, -1e300), 1e30)])
    for config, (baseline_m, step) in zip(OTHERS, motions):
        facts = {"grid": grid, "baseline_m": baseline_m, "step_per_m": step}
        got = stack.focus_input(planes=planes, hypotheses=depth, grid=grid, baseline_m=baseline_m, step_per_m=step,
                                maps=binding_maps(config))
        with np.errstate(invalid="ignore", over="ignore"):
            want = integer_input(cells, facts, config, depth)
        assert np.array_equal(got[0], want[0]) and np.array_equal(got[1], want[1])
        if name in ("zeros", "noise"):
            assert (got[0] != ZERO).any() == (name == "noise" and used > 1)


def test_threads_change_nothing():
    planes = adversarial("noise", 24, 30, 37)
    one, three = (stack.focus_input(planes=planes, hypotheses=32, grid=(37, 30, 80.0, 90.0, 18.5, 14.25), baseline_m=(1, 2, 3),
                                    step_per_m=0.01, maps=binding_maps(InputConfig()), threads=t) for t in (1, 3))
    assert np.array_equal(one[0], three[0]) and np.array_equal(one[1], three[1]) and (one[0] != ZERO).any()


def test_the_reference_support_is_two_boxes():
    cells = np.zeros((1, 7, 7), np.uint16)
    cells[0, 3, 3] = 1
    row = np.array([0, 1, 2, 3, 2, 1, 0])
    assert np.array_equal(support(cells, 3)[0], row[:, None] * row[None, :])
    corner = support(np.ones((1, 2, 2), np.uint16), 3)
    assert np.array_equal(corner[0], np.full((2, 2), 16))  # what the first box makes outside counts as nothing


@pytest.mark.parametrize("maps, words", [(([], 50, 1000), "1 to 8 maps"), (([("gradient", 1)] * 9, 50, 1000), "1 to 8 maps"),
                                         (([("slope", 1)], 50, 1000), "slope"), (([("squares", 4)], 50, 1000), "1, 3, 5, 7"),
                                         (([("squares", 3)], 19, 1000), "floor_events"), (([("squares", 3)], 50, 8001), "floor_noise")])
def test_what_the_library_refuses(maps, words):
    with pytest.raises(stack.StackError, match=words):
        stack.focus_input(planes=np.zeros((8, 32, 32), np.uint8), hypotheses=8, grid=(32, 32, 80.0, 80.0, 16.0, 16.0),
                          baseline_m=(0, 0, 0), step_per_m=1.0, maps=maps)
    with pytest.raises(stack.StackError, match="planes"):
        stack.focus_input(planes=np.zeros((9, 32, 32), np.uint8), hypotheses=8, grid=(32, 32, 80.0, 80.0, 16.0, 16.0),
                          baseline_m=(0, 0, 0), step_per_m=1.0, maps=binding_maps(InputConfig()))
