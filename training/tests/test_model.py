"""Each stage against its equation, by hand on small cases."""
import math

import pytest
import torch

from egofocus_training.config import InputConfig, NetworkConfig, parse_config
from egofocus_training.macs import example_input, layer_table, totals
from egofocus_training.model.aggregation import CrossScaleAggregation
from egofocus_training.model.fcd import FeatureFocusCost, FocusCost, gradient_maps
from egofocus_training.model.feature_pyramid import FeaturePyramid
from egofocus_training.model.ihca import InterHypothesisBlock
from egofocus_training.model.layers import neighbours, per_hypothesis, twice_as_large
from egofocus_training.model.network import FocusNetwork
from egofocus_training.model.refinement import Refinement, gather_focused, nearer_at_borders
from egofocus_training.model.regression import confidence, distribution, expected_index, median_index


def constant_weights(module, value):
    for conv in module.modules():
        if isinstance(conv, torch.nn.Conv2d):
            torch.nn.init.constant_(conv.weight, value)
            if conv.bias is not None:
                torch.nn.init.zeros_(conv.bias)


def test_neighbours_along_the_hypotheses():
    x = torch.tensor([1.0, 4.0, 2.0, 2.0]).reshape(1, 4, 1, 1, 1)
    gd, gdd = neighbours(x)
    assert gd.flatten().tolist() == [1.5, 0.5, -1.0, 0.0]
    assert gdd.flatten().tolist() == [3.0, -5.0, 2.0, 0.0]
    assert per_hypothesis(torch.zeros(2, 4, 3, 5, 6)).shape == (8, 3, 5, 6)


def test_up_sampling_weights_and_size():
    x = torch.zeros(1, 1, 3, 3)
    x[0, 0, 1, 1] = 16
    large = twice_as_large(x, torch.zeros(1, 1, 5, 6))
    assert large.shape == (1, 1, 5, 6)
    assert large[0, 0, :, 1].tolist() == [0, 1 * 1.0, 3, 3, 1]
    assert large[0, 0, :, 2].tolist() == [0, 3, 9, 9, 3]


def test_gradient_maps():
    y, x = torch.meshgrid(torch.arange(5.0), torch.arange(6.0), indexing="ij")
    features = (x * x + 2 * y * y + 3 * x * y)[None, None]
    maps = gradient_maps(features)[0, :, 2, 3].tolist()
    #        Gx = 2x + 3y, Gy = 4y + 3x, Gxx = 2, Gyy = 4, Gxy = 3, Gxx * Gyy = 8 at (3, 2)
    assert maps == [12, 17, 2, 4, 3, 8]


def test_feature_focus_cost_is_the_root_of_the_support_sum():
    fcd = FeatureFocusCost(1).eval()
    constant_weights(fcd.discriminate, 0.0)
    with torch.no_grad():
        fcd.discriminate[0].weight[0, 0, 1, 1] = 1.0  # Gx passes, all else is 0
        fcd.combine.weight.fill_(1.0)
    features = (torch.arange(8.0) * 2).expand(1, 1, 7, 8)  # Gx = 2 inside
    cost = fcd(features)
    assert cost.shape == (1, 1, 1, 7, 8)
    scale = 1 / math.sqrt(1 + 1e-5)  # batch norm at rest
    assert cost[0, 0, 0, 3, 3].item() == pytest.approx(math.sqrt(9 * (2 * scale) ** 2 + 1e-4), rel=1e-5)


def test_focus_cost_shares_its_filter_and_sees_one_hypothesis_alone():
    fcd = FocusCost(3, 8, 4).eval()
    z = torch.randn(2, 5, 3, 6, 7)
    cost = fcd(z)
    assert cost.shape == (2, 5, 4, 6, 7)
    swapped = fcd(z.flip(1))
    assert torch.allclose(swapped.flip(1), cost, atol=1e-6)
    z[:, 2] += 1
    assert torch.equal(fcd(z)[:, 3], cost[:, 3])
    assert FocusCost(3, 0, 4)(z).shape == (2, 5, 4, 6, 7) and len(list(FocusCost(3, 0, 4).parameters())) == 3
    assert FocusCost(3, 8, 0).channels == 3 and torch.equal(FocusCost(3, 8, 0)(z), z)


def test_ihca_adds_what_the_neighbours_say():
    block = InterHypothesisBlock(1).eval()
    constant_weights(block, 0.0)
    with torch.no_grad():
        block.filter[0].weight[0, 2, 1, 1] = 1.0  # Gdd alone
    cost = torch.tensor([1.0, 4.0, 2.0, 2.0]).reshape(1, 4, 1, 1, 1)
    scale = 1 / math.sqrt(1 + 1e-5)
    expected = [1 + 3 * scale, 0.0, 2 + 2 * scale, 2.0]  # relu(C + Gdd)
    assert block(cost).flatten().tolist() == pytest.approx(expected, rel=1e-5)


def test_aggregation_begins_as_the_cost_itself():
    torch.manual_seed(1)
    stage = CrossScaleAggregation(8, 2, 3, [16, 16, 16], [1, 1, 1], [1, 1]).eval()
    cost = torch.rand(2, 8, 2, 9, 11)
    scores, coarse, features = stage(cost, torch.randn(2, 3, 9, 11))
    assert scores.shape == (2, 8, 9, 11) and coarse is None and features.shape == (2, 16, 9, 11)
    assert torch.allclose(scores, cost.mean(2), atol=1e-6)
    assert stage.train()(cost, torch.randn(2, 3, 9, 11))[1].shape == (2, 8, 5, 6)


def test_feature_pyramid_gives_one_channel_per_hypothesis_at_a_quarter():
    stage = FeaturePyramid(8, 8, [8, 16, 16], [1, 1, 1]).eval()
    assert stage(torch.zeros(1, 8, 50, 46)).shape == (1, 8, 13, 12)


def test_distribution_and_index():
    scores = torch.tensor([0.0, math.log(2), math.log(5), 9.0]).reshape(1, 4, 1, 1)
    p = distribution(scores, torch.tensor([3]))  # the fourth is no hypothesis of this ladder
    assert p.flatten().tolist() == pytest.approx([1 / 8, 2 / 8, 5 / 8, 0])
    assert expected_index(p).item() == pytest.approx((2 + 10) / 8)
    # Weights p (8 k + 1): 1, 18, 85 of 104 (of eighths): half of them is 33 into the third, which reaches from 1.5 to 2.5.
    assert median_index(p, torch.tensor([3])).item() == pytest.approx(1.5 + 33 / 85)


def test_confidence_is_parallax_over_spread():
    p = torch.tensor([0.1, 0.2, 0.4, 0.2, 0.1]).reshape(1, 5, 1, 1)
    index = torch.full((1, 1, 1), 2.0)
    assert confidence(p, index, torch.full((1, 1, 1), 1.5)).item() == pytest.approx(3 / (3 + 1.5 * 1.2 ** 0.5 + 1))
    assert confidence(p, index, torch.zeros(1, 1, 1)).item() == 0  # nothing moves here
    at_end = confidence(p, torch.full((1, 1, 1), 4.0), torch.full((1, 1, 1), 1.0)).item()
    assert at_end == pytest.approx(4 / (4 + 5.2 ** 0.5 + 1))


def test_gathering_around_the_prediction():
    half = torch.arange(5, dtype=torch.uint8).reshape(1, 5, 1, 1).repeat(1, 1, 1, 2) * 4
    focused = gather_focused(half, torch.tensor([[[1.4, 4.0]]]))
    assert focused[0, :, 0, 0].tolist() == [0, 1, 2]
    assert focused[0, :, 0, 1].tolist() == [3, 3.75, 0]  # 16 saturates at 15; beyond the ladder 0


def test_refinement_begins_as_the_prediction_and_stays_inside_the_ladder():
    stage = Refinement(8, 16, 16, [1, 2]).eval()
    index = torch.full((1, 5, 6), 3.25)
    half = torch.zeros(1, 8, 9, 12, dtype=torch.uint8)
    assert torch.allclose(stage(index, half, torch.randn(1, 16, 5, 6), torch.tensor([8])), torch.tensor(3.25))
    with torch.no_grad():
        stage.last.bias.fill_(100.0)
    assert stage(index, half, torch.zeros(1, 16, 5, 6), torch.tensor([6])).unique().tolist() == [5]


def test_borders_belong_to_the_nearer_surface():
    index = torch.tensor([[[3.0, 3, 3.5, 5, 8, 8], [3, 3, 3, 3, 3, 3], [3, 3, 3, 3, 3, 3]]])
    # Two hypotheses, as from 3 to 5, are no border yet.
    expected = [[3, 3, 3.5, 8, 8, 8], [3, 3, 3, 8, 8, 8], [3, 3, 3, 3, 3, 3]]
    assert nearer_at_borders(index).tolist() == [expected]


@pytest.mark.parametrize("order, ihca", [("focus_first", 0), ("focus_first", 1), ("published", 1)])
@pytest.mark.parametrize("size", [(346, 260), (208, 160)])
def test_shapes(order, ihca, size):
    config = parse_config("[input]\nhypotheses = 16\n[network]\nwidths = [16, 16, 16]\nblocks = [0, 1, 1]\n"
                          f"order = '{order}'\nihca_blocks = {ihca}\nstem = 8\n", "test")
    network = FocusNetwork(config.input, config.network).train()
    prediction = network(example_input(config, *size, batch=2))
    width, height = size
    assert prediction.scores.shape == (2, 16, -(-height // 4), -(-width // 4))
    assert prediction.index.shape == (2, -(-height // 2), -(-width // 2))
    assert prediction.confidence.shape == prediction.index_4.shape == (2, -(-height // 4), -(-width // 4))
    (prediction.index.sum() + prediction.scores.sum()).backward()
    unused = [name for name, p in network.named_parameters() if p.grad is None]
    assert [name for name in unused if "coarse_head" not in name] == []


def test_every_operator_has_an_integer_form():
    for order in ("focus_first", "published"):
        network = FocusNetwork(InputConfig(), NetworkConfig(order=order, ihca_blocks=1))
        leaves = {type(m).__name__ for m in network.modules() if not list(m.children())}
        assert leaves <= {"Conv2d", "Conv", "BatchNorm2d", "ReLU", "Bytes", "Sequential"}  # Sequential: an empty one


def test_cost_of_a_layer_and_the_budgets():
    import pathlib

    from egofocus_training.config import load_config
    configs = pathlib.Path(__file__).parent.parent / "configs"
    for name, macs in (("base", 1.6e9), ("small", 0.35e9), ("base_published", 1.6e9)):
        config = load_config(configs / f"{name}.toml")
        rows = layer_table(config, 346, 260)
        total = totals(rows)
        assert total["macs"] <= macs and total["weight_bytes"] <= 1.5e6, name
        assert total["macs"] > 0.8 * macs, name  # what is not spent is not used
    rows = {r["layer"]: r for r in layer_table(load_config(configs / "base.toml"), 346, 260)}
    first = rows["fcd.filter.0.0"]
    assert first["macs"] == 32 * 65 * 87 * 5 * 9 * 8 and first["weight_bytes"] == 5 * 9 * 8 + 8 * 8
