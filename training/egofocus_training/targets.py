"""Truth in steps of the ladder: the index i = rho / step at three scales, and its histogram over hypotheses.

An index nearer than the ladder's last hypothesis K - 1 counts as K - 1: the nearest that can be said. The sky is 0.
"""
import numpy as np


def index_of(inverse_depth, step_per_m, hypotheses):
    """Truth's index, float32 [h, w], within 0..K-1."""
    return np.clip(inverse_depth / np.float32(step_per_m), 0, hypotheses - 1).astype(np.float32)


def cells_of(values, side, fill):
    """[ceil(h / side), ceil(w / side), side^2], the border filled."""
    h, w = values.shape
    rows, columns = -(-h // side), -(-w // side)
    padded = np.full((rows * side, columns * side), fill, values.dtype)
    padded[:h, :w] = values
    return padded.reshape(rows, side, columns, side).transpose(0, 2, 1, 3).reshape(rows, columns, side * side)


def coarse_index(index, weight, side):
    """(index, weight) of cells: the lower median, so that no depth is made up at a border; the mean weight."""
    values = np.sort(np.where(cells_of(weight, side, 0) > 0, cells_of(index, side, 0), np.inf), axis=2)
    known = np.isfinite(values).sum(axis=2)
    middle = np.take_along_axis(values, np.maximum(known - 1, 0)[..., None] // 2, axis=2)[..., 0]
    share = cells_of(weight, side, 0).mean(axis=2)
    return np.where(known > 0, middle, 0).astype(np.float32), share.astype(np.float32)


def borders(index, reach, least):
    """Where indices within `reach` cells differ by `least` or more: bool, shape of index [h, w]."""
    def widest(values, choose):
        for axis in (0, 1):
            padding = [(reach, reach) if a == axis else (0, 0) for a in (0, 1)]
            padded = np.pad(values, padding, mode="edge")
            values = choose.reduce([padded.take(range(s, s + values.shape[axis]), axis) for s in range(2 * reach + 1)])
        return values

    return widest(index, np.maximum) - widest(index, np.minimum) >= least


def histogram(index, weight, side, hypotheses, width):
    """[D, h / side, w / side]: each pixel of a cell spread over hypotheses by exp(-|k - i| / width), |k - i| < 5; sums 1
    where anything is known."""
    cells = cells_of(index, side, 0)
    weights = cells_of(weight, side, 0).astype(np.float64)
    rows, columns, pixels = cells.shape
    cell_count = rows * columns
    low = np.minimum(cells.astype(np.int64), hypotheses - 2)
    high_weight = (cells - low) * weights
    at = low * cell_count + np.arange(cell_count).reshape(rows, columns, 1)
    bins = np.bincount(at.ravel(), (weights - high_weight).ravel(), hypotheses * cell_count)
    bins[cell_count:] += np.bincount(at.ravel(), high_weight.ravel(), hypotheses * cell_count)[:-cell_count]
    bins = bins.astype(np.float32).reshape(hypotheses, rows, columns)
    out = bins.copy()
    for reach in range(1, 5):
        share = np.float32(np.exp(-reach / width))
        out[reach:] += share * bins[:-reach]
        out[:-reach] += share * bins[reach:]
    out /= np.maximum(out.sum(axis=0), 1e-9)
    return out
