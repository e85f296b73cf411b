"""The integer model against the quantised network it was made of, and its rules by hand."""
import pathlib

import numpy as np
import pytest
import torch

from egofocus_training import integer_model
from egofocus_training.config import load_config, parse_config
from egofocus_training.errors import TrainingError
from egofocus_training.evaluate import load_network
from egofocus_training.integer_model import IntegerConv, IntegerModel
from egofocus_training.macs import example_input
from egofocus_training.model.bytes import Bytes, rounded_weights
from egofocus_training.model.layers import twice_as_large
from egofocus_training.model.network import FocusNetwork
from egofocus_training.quantisation import calibrate, is_quantised, set_rounding
from egofocus_training.units import ZERO
from egofocus_training.vectors import random_window

CONFIG = """
[input]
hypotheses = 16
maps = ["gradient:3", "squares:7"]
[network]
widths = [16, 24, 32]
blocks = [1, 1, 1]
up_blocks = [1, 1]
refine_width = 8
refine_dilations = [1, 2]
"""


def random_inputs(config, seed):
    return random_window(config, seed, 52, 36, 13)


def as_batch(inputs):
    return {name: torch.as_tensor(value)[None] for name, value in inputs.items()}


@pytest.fixture(scope="module")
def quantised():
    """A network that has seen something, with every weight away from its start."""
    torch.manual_seed(3)
    config = parse_config(CONFIG, "test")
    network = FocusNetwork(config.input, config.network)
    for parameter in network.parameters():
        torch.nn.init.normal_(parameter, 0.1 if parameter.ndim == 1 else 0.0, 0.1)
    # Or the refinement would push every pixel to an end of the ladder, where nothing shows.
    torch.nn.init.normal_(network.refinement.last.weight, 0.0, 0.02)
    network.train()
    for seed in range(4):
        network(as_batch(random_inputs(config, seed)))  # batch norm's statistics
    calibrate(network, [as_batch(random_inputs(config, seed)) for seed in range(4)])
    network.eval()
    set_rounding(network, True)
    return config, network


def test_the_integers_are_the_quantised_networks_numbers(quantised):
    config, network = quantised
    seen = {}
    for name, module in network.named_modules():
        if isinstance(module, Bytes):
            module.register_forward_hook(lambda m, _, out, name=name: seen.__setitem__(name, out[0] / m.scale))
    model = IntegerModel(network)
    worst = 0
    changed = {}  # share of each tensor that some tie rounded the other way
    for seed in range(10, 14):
        inputs = random_inputs(config, seed)
        with torch.no_grad():
            prediction = network(as_batch(inputs))
        out = model(**inputs)
        for name, theirs in (("a4", "aggregation.at_4.0.sum"), ("a16", "aggregation.at_16.1.sum"), ("b4", "aggregation.up_4.0.sum"),
                             ("refined", "refinement.body.1.3")):
            difference = np.abs(seen[theirs].numpy() - out[name])
            assert out[name].max() > 60, name  # the range is used
            assert difference.max() < 2.01, name
            changed.setdefault(name, []).append(np.mean(difference > 0.01))
        off = np.abs(prediction.index[0].numpy() * 256 - out["index"])
        worst = max(worst, np.quantile(off, 0.99))
        assert np.median(off) <= 1.0
        trust = np.abs(prediction.confidence[0].numpy() * 255 - out["confidence"])
        assert np.quantile(trust, 0.99) < 3
        assert out["index"].max() <= 256 * 12 and out["index"].dtype == np.uint16
        assert np.mean((out["index"] > 0) & (out["index"] < 256 * 12)) > 0.8  # most pixels are free to differ
    assert worst < 26  # a tenth of a hypothesis
    assert max(np.mean(shares) for shares in changed.values()) < 0.02, changed


def test_quantisation_changes_little(quantised):
    config, network = quantised
    inputs = as_batch(random_inputs(config, 20))
    with torch.no_grad():
        rounded = network(inputs).scores
        set_rounding(network, False)
        exact = network(inputs).scores
        set_rounding(network, True)
    assert not torch.equal(exact, rounded)
    assert (exact - rounded).abs().mean() < 0.1 * exact.std()


def test_a_convolution_by_hand():
    conv = IntegerConv(np.array([[[[1, 2, 3], [4, 5, 6], [7, 8, -9]]]], np.int8), np.array([10], np.int32),
                       np.array([0.5], np.float32), zero=ZERO)
    x = np.full((1, 2, 3), ZERO)
    x[0, 0, 0] += 3  # padding is 0.0, not byte 0
    assert conv.sums(x)[0].tolist() == [[3 * 5 + 10, 3 * 4 + 10, 10], [3 * 2 + 10, 3 * 1 + 10, 10]]
    # halves go to the even neighbour: 12.5 -> 12, 11, 5, 8, 6.5 -> 6, 5
    assert conv.requantised(x)[0].tolist() == [[12, 11, 5], [8, 6, 5]]
    wide = IntegerConv(np.array([[[[127]]]], np.int8), np.array([0], np.int32), np.array([0.9], np.float32))
    assert wide.relu(np.array([[[127, 0]]]))[0].tolist() == [[127, 0]]
    strided = IntegerConv(np.ones((1, 1, 3, 3), np.int8), np.array([0], np.int32), np.array([0.5], np.float32), stride=2)
    assert strided.sums(np.ones((1, 5, 4)))[0].tolist() == [[4, 6], [6, 9], [4, 6]]


def test_up_sampling_is_the_float_one_before_rounding():
    x = torch.arange(12.0).reshape(1, 1, 3, 4) ** 2
    large = twice_as_large(x, torch.zeros(1, 1, 5, 7))[0, 0]
    assert np.array_equal(integer_model.twice_as_large(x[0].numpy().astype(int), 5, 7)[0], (large * 16).numpy())


def test_regression_by_hand():
    scores = np.array([0, 32, 64, 1000]).reshape(4, 1, 1)  # the fourth is no hypothesis of this ladder
    index, trust = IntegerModel._regression(scores, 3, np.full((1, 1), ZERO + 32))
    p = np.exp([0.0, 1.0, 2.0])
    w = p * [1, 9, 17]
    median = 1.5 + (w.sum() / 2 - w[0] - w[1]) / w[2]
    assert abs(index[0, 0] - 256 * median) <= 0.51
    spread = np.sqrt((p * (np.arange(3) - median) ** 2).sum() / p.sum())
    # 32 bytes above zero: 1 px a hypothesis
    assert abs(trust[0, 0] - 255 * median / (median + spread + 1)) <= 1.1
    assert IntegerModel._regression(scores, 3, np.full((1, 1), ZERO))[1][0, 0] == 0


def test_one_of_two_depths_is_taken_and_the_ladders_ends_are_kept():
    step = np.full((1, 1), ZERO + 32)
    two = np.array([0, 96, 0, 0, 0, 0, 90, 0]).reshape(8, 1, 1)  # the nearer one is a little less likely
    index, _ = IntegerModel._regression(two, 8, step)
    assert abs(index[0, 0] - 256 * 6) < 128
    for at, end in ((0, 0), (7, 256 * 7)):
        sure = np.zeros((8, 1, 1), int)
        sure[at] = 800
        assert IntegerModel._regression(sure, 8, step)[0][0, 0] == end


def test_weights_round_to_int8_with_a_scale_for_each_output():
    weight = torch.tensor([[1.0, -0.5], [0.02, 0.0]]).reshape(2, 2, 1, 1)
    rounded, scale = rounded_weights(weight)
    assert scale.tolist() == pytest.approx([1 / 127, 0.02 / 127])
    assert (rounded[:, :, 0, 0] / scale[:, None]).round().tolist() == [[127, -64], [127, 0]]
    columns = torch.tensor([1.0, 4.0])
    rounded, scale = rounded_weights(weight, columns)
    assert scale.tolist() == pytest.approx([2 / 127, 0.02 / 127])
    assert (rounded * columns.reshape(1, 2, 1, 1) / scale.reshape(2, 1, 1, 1)).round().flatten().tolist() == [64, -127, 127, 0]


def test_a_channel_that_died_keeps_its_bias(quantised):
    config, _ = quantised
    torch.manual_seed(4)
    network = FocusNetwork(config.input, config.network)  # head and last begin at zero
    with torch.no_grad():
        network.aggregation.head.bias[5] = 3.0
        network.aggregation.head.weight[5] = 1e-30
    calibrate(network, [as_batch(random_inputs(config, 1))])
    set_rounding(network, True)
    model = IntegerModel(network)
    assert np.abs(model.head.weight[5]).max() == 0
    x = np.full((16, 1, 1), 100)
    assert model.head.requantised(x)[:, 0, 0].tolist() == [96 if o == 5 else 0 for o in range(16)]  # 3.0 in 32nds


def test_what_has_no_integer_form_is_refused(quantised):
    config = parse_config(CONFIG + "order = 'published'\nstem = 8\n", "test")
    network = FocusNetwork(config.input, config.network)
    with pytest.raises(TrainingError, match="no integer form"):
        calibrate(network, [])
    with pytest.raises(ValueError):
        IntegerModel(FocusNetwork(quantised[0].input, quantised[0].network))
    assert is_quantised(quantised[1]) and not is_quantised(network)


def test_shipped_weights_load_and_have_integers():
    folder = pathlib.Path(__file__).resolve().parents[2] / "models" / "base"
    config = load_config(folder / "config.toml")
    model = IntegerModel(load_network(folder / "weights.pt", config))
    out = model(**{name: tensor[0].numpy() for name, tensor in example_input(config, 64, 48).items()})
    assert out["index"].shape == (24, 32) and model.hypotheses == config.input.hypotheses == 32
    weights = sum(conv.weight.size for conv in (model.mix, model.down_8, model.down_16, model.head))
    assert weights > 100_000 and np.abs(model.mix.weight).max() == 127
