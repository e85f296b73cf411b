"""Loss and metrics by hand."""
import math

import numpy as np
import pytest
import torch

from egofocus_training.config import LossConfig
from egofocus_training.losses import cross_entropy, huber, log_error, loss_terms, relative_error, weighted_mean
from egofocus_training.metrics import MeanMetrics, depth_of, enlarge, image_metrics, pixel_sets
from egofocus_training.model.network import Prediction


def test_parts():
    scores = torch.tensor([0.0, math.log(3), 7.0]).reshape(1, 3, 1, 1)
    label = torch.tensor([0.5, 0.5, 0.0]).reshape(1, 3, 1, 1)
    expected = -(0.5 * math.log(1 / 4) + 0.5 * math.log(3 / 4))
    assert cross_entropy(scores, label, torch.tensor([2])).item() == pytest.approx(expected)
    assert huber(torch.tensor([0.5, -3.0])).tolist() == [0.125, 2.5]
    assert log_error(torch.tensor(0.0), torch.tensor(9.5), 0.5, 0.0).item() == pytest.approx(math.log(20))
    assert log_error(torch.tensor(2.0), torch.tensor(7.0), 0.5, 2.0).item() == pytest.approx(math.log(3) + 2 * math.log(3) ** 2)
    assert weighted_mean(torch.tensor([1.0, 5.0]), torch.tensor([3.0, 1.0])).item() == 2.0
    assert weighted_mean(torch.tensor([1.0]), torch.tensor([0.0])).item() == 0


def test_the_whole():
    scores = torch.zeros(1, 4, 2, 2)
    label = torch.zeros(1, 4, 2, 2)
    label[:, 1] = 1
    batch = {"used": torch.tensor([4]), "label": label, "index_4": torch.full((1, 2, 2), 1.0),
             "weight_4": torch.tensor([[[1.0, 0], [0, 0]]]), "index_2": torch.full((1, 4, 4), 2.0),
             "weight_2": torch.ones(1, 4, 4)}
    prediction = Prediction(scores, torch.zeros(1, 4, 1, 1), torch.full((1, 2, 2), 3.0), torch.full((1, 4, 4), 2.0), None, None)
    config = LossConfig(distribution=2.0, index=0.5, log_depth=3.0, log_floor=0.5, log_square=0.0, refined=7.0, coarse=0.25)
    prediction.index[0, 0, 0] = 0.5
    terms = {name: term.item() for name, term in loss_terms(prediction, batch, config).items()}
    # Four hypotheses alike: their mean is 1.5, the truth 1; refined 2 where 2 is true, but for one of 16 cells, at 0.5.
    assert terms == pytest.approx({"distribution": 2 * math.log(4), "index": 0.5 * 0.125, "log_depth": 3 * math.log(2.0 / 1.5),
                                   "refined": 7 * 1.5 / 16, "coarse": 0.25 * math.log(4)}, rel=1e-5)
    assert relative_error(torch.tensor([0.0, 4.0]), torch.tensor([8.0, 8.0]), 0.25).tolist() == pytest.approx([4, 4 / 4.25])


def test_a_far_blunder_costs_more_than_a_near_one():
    config = LossConfig()
    truth = torch.tensor([10.0])
    sky, nearer = (log_error(torch.tensor([i]), truth, config.log_floor, config.log_square) for i in (0.0, 20.0))
    assert sky > 4 * nearer


def test_enlarging_keeps_edges():
    index = np.array([[4.0, 5.0], [4.0, 20.0]])
    large = enlarge(index, 4, 4)
    assert large[1, 1] == pytest.approx((9 * 4 + 3 * 5 + 3 * 4 + 4) / 16)  # 20 is another surface
    assert large[0, 0] == 4 and large[3, 3] == 20
    assert enlarge(index, 3, 4).shape == (3, 4)


def test_metrics_of_an_image():
    inverse_depth = np.array([[0.5, 0.1, 0.0, 0.01]])
    masks, truth = pixel_sets(inverse_depth, np.array([[1, 0, 1, 1]]), 0.1, 4)
    assert masks["all"].tolist() == [[True, True, False, False]]  # sky, and 100 m
    assert masks["all_in_ladder"].tolist() == [[False, True, False, False]]  # 0.5 / 0.1 is beyond hypothesis 3
    assert masks["events"].tolist() == [[True, False, False, False]]
    depth = depth_of(np.array([[4.0, 0.0, 1.0, 1.0]]), 0.1)  # 2.5 m, infinity
    got = image_metrics(depth, truth, masks["all"], 0.1)
    assert got["abs_rel"] == pytest.approx((0.5 / 2 + 70 / 10) / 2)
    assert got["d1"] == 0  # 1.25 is not below 1.25
    assert got["rmse_log"] == pytest.approx(math.sqrt((math.log(1.25) ** 2 + math.log(8) ** 2) / 2))
    assert got["idx_mae"] == pytest.approx((1 + (0.1 - 1 / 80) / 0.1) / 2)
    assert image_metrics(depth, truth, masks["events_in_ladder"], 0.1) is None
    means = MeanMetrics()
    means.add("network", "room", "all", got)
    means.add("network", "desk", "all", {**got, "d1": 1.0})
    means.add("network", "desk", "events", None)
    rows = {(r["family"], r["set"]): r for r in means.rows()}
    assert rows["overall", "all"]["images"] == 2 and rows["overall", "all"]["d1"] == 0.5 and len(rows) == 3
