"""Regression: scores -> distribution over hypotheses -> index.

    p_k = softmax_k S,  k < K
    median:       i = the median of the weights w_k = p_k (k + 1/8), each spread evenly over k - 1/2 .. k + 1/2
    expectation:  i = sum_k k p_k
The weighted median is the index of least expected |d - g| / g: with d = 1 / i and g = 1 / k that is k |1 / i - 1 / k|, whose
least sum is at the median of 1 / k under the weights k p_k. (An eighth, so that the sky has a say.) Between two depths it takes one of
them, in doubt the nearer one; an expectation makes up a third. It has no useful gradient: what teaches p
stands in losses.py.
    confidence = m / (m + s + 1 px),   m: parallax at i in px,  s: the spread of p about i, as a parallax
"""
import torch

_SKY = 1 / 8  # hypotheses
_HALF_TRUST_PX = 1.0  # as in the classical backend


def distribution(scores, used):
    """Softmax over the hypotheses k < used; scores [B, D, h, w], used [B]."""
    k = torch.arange(scores.shape[1], device=scores.device)
    outside = (k[None] >= used[:, None])[:, :, None, None]
    return torch.softmax(scores.float().masked_fill(outside, -1e4), 1)


def _hypotheses_like(p):
    return torch.arange(p.shape[1], dtype=p.dtype, device=p.device)[None, :, None, None]


def expected_index(p):
    """[B, h, w] of p [B, D, h, w]."""
    return (p * _hypotheses_like(p)).sum(1)


@torch.no_grad()
def median_index(p, used):
    """[B, h, w] of p [B, D, h, w], within 0 .. used - 1."""
    weight = p * (_hypotheses_like(p) + _SKY)
    below = weight.cumsum(1)
    half = below[:, -1:] / 2
    best = (below < half).sum(1, keepdim=True).clamp(max=p.shape[1] - 1)
    own = weight.gather(1, best)
    index = (best + 0.5 - (below.gather(1, best) - half) / own)[:, 0]
    return torch.minimum(index.clamp(min=0), (used - 1)[:, None, None].to(index.dtype))


def confidence(p, index, step_px):
    """[B, h, w] in 0..1. step_px [B, h, w]: what one hypothesis moves."""
    spread = torch.sqrt((p * (_hypotheses_like(p) - index[:, None]) ** 2).sum(1))
    return index * step_px / ((index + spread) * step_px + _HALF_TRUST_PX)
