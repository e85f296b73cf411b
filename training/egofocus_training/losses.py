"""The loss: is the distribution right, is its mean not grossly wrong, and is the refined depth right?

    L = a H(label, p) + b huber(m - t) + c (|l| + f l^2) + g min(|t_2 - i| / (i + e), 4) + d H(label_8, p_8)
t, t_2: truth's index at 1/4 and 1/2; m: the mean of p, l = ln((m + e) / (t + e)); i: the refined index; every term a mean over cells,
weighted where things move and, at 1/2, at borders. The error of the refined index is that of depth relative to truth, whose
least expectation the regression looks for, too: with an error that is alike on both sides, refinement would move what is in doubt
back, away from the camera. The mean teaches p how far off a wrong hypothesis is, which H does not.
"""
import torch
from torch.nn import functional

from .model.regression import distribution, expected_index

_MOST_RELATIVE = 4.0  # beyond, nothing that refinement could still reach


def weighted_mean(values, weight):
    return (values * weight).sum() / weight.sum().clamp(min=1e-6)


def cross_entropy(scores, label, used):
    """-sum_k label_k ln p_k over k < used; [B, h, w]"""
    k = torch.arange(scores.shape[1], device=scores.device)
    outside = (k[None] >= used[:, None])[:, :, None, None]
    log_p = torch.log_softmax(scores.float().masked_fill(outside, -1e4), 1)
    return -(label.masked_fill(outside, 0) * log_p).sum(1)


def huber(error, knee=1.0):
    size = error.abs()
    return torch.where(size < knee, size * size / (2 * knee), size - knee / 2)


def log_error(index, truth, floor, square):
    size = torch.log((index + floor) / (truth + floor)).abs()
    return size + square * size * size


def relative_error(index, truth, floor):
    return ((truth - index).abs() / (index + floor)).clamp(max=_MOST_RELATIVE)


def loss_terms(prediction, batch, config):
    """The terms by name, weighted; their sum is the loss."""
    used = batch["used"]
    terms = {"distribution": config.distribution *
             weighted_mean(cross_entropy(prediction.scores, batch["label"], used), batch["weight_4"])}
    mean, truth, weight = expected_index(distribution(prediction.scores, used)), batch["index_4"], batch["weight_4"]
    terms["index"] = config.index * weighted_mean(huber(mean - truth), weight)
    terms["log_depth"] = config.log_depth * weighted_mean(log_error(mean, truth, config.log_floor, config.log_square), weight)
    refined = prediction.index.float().clamp(min=0)
    terms["refined"] = config.refined * weighted_mean(relative_error(refined, batch["index_2"], config.log_floor), batch["weight_2"])
    if prediction.coarse is not None and config.coarse > 0:
        weight = functional.avg_pool2d(batch["weight_4"][:, None], 2, ceil_mode=True)
        label = functional.avg_pool2d(batch["label"] * batch["weight_4"][:, None], 2, ceil_mode=True) / weight.clamp(min=1e-6)
        terms["coarse"] = config.coarse * weighted_mean(cross_entropy(prediction.coarse, label, used), weight[:, 0])
    return terms
