"""Metrics of one image, as docs/accuracy.md and `egofocus eval` define them: truth in (0, 80] m, estimates clipped to 0.1..80 m."""
import numpy as np

CUT_M = 80.0
CLIP_M = (0.1, 80.0)
SETS = ("all", "events", "all_in_ladder", "events_in_ladder")
NAMES = ("d1", "abs_rel", "rmse_log", "idx_mae")


def enlarge(index, height, width):
    """1/2 -> 1: between the four nearest centres (9 3 3 1 of 16); one further than two hypotheses away counts as the own one."""
    return _sixteenths(index, height, width, 2) / 16


def enlarge_q8(index_q8, height, width):
    """The same of whole 1/256 hypotheses, rounded half up: what the library does, byte for byte."""
    return (_sixteenths(index_q8.astype(np.int64), height, width, 512) + 8) >> 4


def _sixteenths(index, height, width, edge):
    def shifted(values, axis, positions):
        size = values.shape[axis]
        beside = np.where(positions % 2 == 1, positions // 2 + 1, positions // 2 - 1)
        beside = np.where((beside < 0) | (beside >= size), positions // 2, beside)
        return positions // 2, beside

    own_y, beside_y = shifted(index, 0, np.arange(height))
    own_x, beside_x = shifted(index, 1, np.arange(width))
    own = index[np.ix_(own_y, own_x)]
    total = 9 * own
    for rows, columns, weight in ((own_y, beside_x, 3), (beside_y, own_x, 3), (beside_y, beside_x, 1)):
        value = index[np.ix_(rows, columns)]
        total = total + weight * np.where(np.abs(value - own) > edge, own, value)
    return total


def depth_of(index, step_per_m):
    """Metres, clipped; index 0 is infinity."""
    with np.errstate(divide="ignore"):
        return np.clip(1.0 / (np.maximum(index, 0) * step_per_m), *CLIP_M)


def pixel_sets(inverse_depth, event_mask, step_per_m, hypotheses):
    """Boolean masks by name of SETS, and the truth in metres."""
    with np.errstate(divide="ignore"):
        truth_m = 1.0 / inverse_depth.astype(np.float64)
    valid = np.isfinite(truth_m) & (truth_m <= CUT_M)
    index = inverse_depth / step_per_m
    inside = valid & (index >= 0.5) & (index <= hypotheses - 1)
    hit = event_mask > 0
    return {"all": valid, "events": valid & hit, "all_in_ladder": inside, "events_in_ladder": inside & hit}, truth_m


def image_metrics(depth_m, truth_m, mask, step_per_m):
    """Metrics by name over a mask; None where it is empty."""
    if not mask.any():
        return None
    d, g = depth_m[mask], truth_m[mask]
    return {"d1": float(np.mean(np.maximum(d / g, g / d) < 1.25)), "abs_rel": float(np.mean(np.abs(d - g) / g)),
            "rmse_log": float(np.sqrt(np.mean(np.square(np.log(d / g))))),
            "idx_mae": float(np.mean(np.abs(1 / d - 1 / g)) / step_per_m)}


class MeanMetrics:
    """Means over images: by method, family and pixel set."""

    def __init__(self):
        self._sums = {}

    def add(self, method, family, pixel_set, values):
        if values is None:
            return
        for group in (family, "overall"):
            count, sums = self._sums.setdefault((method, group, pixel_set), [0, dict.fromkeys(NAMES, 0.0)])
            for name in NAMES:
                sums[name] += values[name]
            self._sums[method, group, pixel_set][0] = count + 1

    def rows(self):
        """[{method, family, set, images, d1, ...}]"""
        return [{"method": method, "family": family, "set": pixel_set, "images": count,
                 **{name: value / count for name, value in sums.items()}}
                for (method, family, pixel_set), (count, sums) in self._sums.items()]
