"""The loss: is the distribution right, is the index right, and is the depth not grossly wrong?

    L = a H(label, p) + b sum_s huber(i_s - t_s) + c sum_s (|l_s| + f l_s^2) + d H(label_8, p_8),  l = ln((i + e) / (t + e))
s: 1/2 (refined), and 1/4 where the regression has a gradient (an expectation); t: truth's index; every term a mean over cells, weighted where things move.
l is the error of log depth: sky in place of a near wall costs ln(1 + t / e), and its square more than many small errors.
Without the square the estimate is a median, which in doubt goes far away.
"""
import torch
from torch.nn import functional


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


def loss_terms(prediction, batch, config):
    """The terms by name, weighted; their sum is the loss."""
    used = batch["used"]
    terms = {"distribution": config.distribution *
             weighted_mean(cross_entropy(prediction.scores, batch["label"], used), batch["weight_4"])}
    index = log = 0.0
    for estimate, scale in ((prediction.index_4, 4), (prediction.index, 2)):
        if not estimate.requires_grad and prediction.index.requires_grad:
            continue
        truth, weight = batch[f"index_{scale}"], batch[f"weight_{scale}"]
        index = index + weighted_mean(huber(estimate.float() - truth), weight)
        log = log + weighted_mean(log_error(estimate.float().clamp(min=0), truth, config.log_floor, config.log_square),
                                  weight)
    terms["index"] = config.index * index
    terms["log_depth"] = config.log_depth * log
    if prediction.coarse is not None and config.coarse > 0:
        weight = functional.avg_pool2d(batch["weight_4"][:, None], 2, ceil_mode=True)
        label = functional.avg_pool2d(batch["label"] * batch["weight_4"][:, None], 2, ceil_mode=True) / weight.clamp(min=1e-6)
        terms["coarse"] = config.coarse * weighted_mean(cross_entropy(prediction.coarse, label, used), weight[:, 0])
    return terms
