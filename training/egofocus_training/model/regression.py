"""Regression: scores -> distribution over hypotheses -> index.

    p_k = softmax_k S,  k < K;   i = sum_k k p_k,  over |k - argmax S| <= window where one is set
    confidence = P * m / (m + 1 px),   P = p summed over the three hypotheses around i,  m: parallax at i in px
"""
import torch

_HALF_TRUST_PX = 1.0  # as in the classical backend


def distribution(scores, used):
    """Softmax over the hypotheses k < used; scores [B, D, h, w], used [B]."""
    k = torch.arange(scores.shape[1], device=scores.device)
    outside = (k[None] >= used[:, None])[:, :, None, None]
    return torch.softmax(scores.float().masked_fill(outside, -1e4), 1)


def expected_index(p, window=0):
    """[B, h, w]; window 0: over all hypotheses."""
    k = torch.arange(p.shape[1], dtype=p.dtype, device=p.device)[None, :, None, None]
    if window > 0:
        p = p * ((k - p.argmax(1, keepdim=True)).abs() <= window)
        p = p / p.sum(1, keepdim=True)
    return (p * k).sum(1)


def confidence(p, index, step_px):
    """[B, h, w] in 0..1. step_px [B, h, w]: what one hypothesis moves."""
    nearest = (index + 0.5).floor().long().clamp(0, p.shape[1] - 1)
    mass = sum(p.gather(1, (nearest + d).clamp(0, p.shape[1] - 1)[:, None])[:, 0] * ((nearest + d >= 0) & (nearest + d < p.shape[1]))
               for d in (-1, 0, 1))
    moved = index * step_px
    return mass * moved / (moved + _HALF_TRUST_PX)
