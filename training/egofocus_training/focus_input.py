"""What the network is told of a window: sharpness of each hypothesis, normalised, and a few maps of context. No weights.

Per cell p of 4x4 px, hypothesis k < K and map m (an energy E and the counts S under the same support, from the library):
    R_k = E_k / (S_k + n floor_events)                 n = 16 side^4: the support's whole weight, in pixels
    z_k = (R_k - mean_k R) / (sd_k R + floor_noise q)  q^2 = a / (m (mean_k S / n + floor_events))
q is about what sd would be if events were evenly spread, m the number of pixels that a support rests on: (6 side)^2, since its
two boxes overlap, and 16 without a support.
Hypotheses k >= K, which the ladder left out, are 0. Context: density of events under both ends of the supports, log of
sd / q of each map, the parallax of one hypothesis at p in px (x, y, norm), and K / D.
Both leave as bytes 0..127 about 64, in the steps of units.py: the integer model starts from them.
"""
import numpy as np

from . import library
from .units import CONTEXT, FOCUS, HIGH, ZERO

_NOISE = 4.0  # a: a gradient's energy is 4 per event where events are evenly spread, and varies as much


def context_channels(config):
    """Channels of the context of an InputConfig."""
    return 2 + len(config.maps) + 3 + 1


def parse_maps(maps):
    """[(name, side of the support in cells)]"""
    pairs = [entry.split(":") for entry in maps]
    return [(name, int(side)) for name, side in pairs]


def to_bytes(values, step):
    """Round half to even, saturate."""
    scaled = np.multiply(values, 1 / step, dtype=np.float32)
    np.rint(scaled, out=scaled)
    scaled += ZERO
    return np.clip(scaled, 0, HIGH, out=scaled).astype(np.uint8)


def normalised(energy, counts, side, config):
    """(z [K, h, w], log2(1 + sd / q) / 4 [h, w]) of an energy [K, h, w] and counts under the same support."""
    n = 16.0 * side ** 4
    ratio = energy / (counts + np.float32(n * config.floor_events))
    ratio -= ratio.mean(axis=0)
    sd = np.sqrt(np.einsum("khw,khw->hw", ratio, ratio) / len(ratio))
    density = counts.mean(axis=0) / n
    m = (6.0 * side) ** 2 if side > 1 else 16.0
    q = np.sqrt(_NOISE / (m * (density + config.floor_events)))
    ratio *= 1 / (sd + config.floor_noise * q)
    return ratio, np.log2(1 + sd / q) / 4


def displacement_px(facts):
    """What one hypothesis more moves at each cell's centre: [2, h, w] px."""
    width, height, fx, fy, cx, cy = facts["grid"]
    x, y, z = (c * facts["step_per_m"] for c in facts["baseline_m"])
    u = 4 * np.arange((width + 3) // 4, dtype=np.float32) + 1.5
    v = 4 * np.arange((height + 3) // 4, dtype=np.float32) + 1.5
    return np.stack(np.broadcast_arrays(fx * x - z * (u[None, :] - cx), fy * y - z * (v[:, None] - cy)))


def network_input(facts, config):
    """(focus u8 [D, maps, h, w], context u8 [channels, h, w]) of a window's facts and its `cells`."""
    used, cells = facts["hypotheses"], facts["cells"]
    depth, (h, w) = cells.shape[1], cells.shape[2:]
    gradient_x, gradient_y, squares, counts = (cells[i, :used] for i in range(4))
    supported = {}

    def support(name, side):
        if (name, side) not in supported:
            if name == "gradient":
                value = support("gradient_x", side) + support("gradient_y", side)
            else:
                cell_map = {"gradient_x": gradient_x, "gradient_y": gradient_y, "squares": squares, "counts": counts}[name]
                value = library.stack.support(cell_map, side)
            supported[name, side] = value
        return supported[name, side]

    maps = parse_maps(config.maps)
    focus = np.full((depth, len(maps), h, w), ZERO, np.uint8)
    context = []
    for side in (1, 7):
        context.append(np.log2(1 + support("counts", side).mean(axis=0) / side ** 4) / 4)
    for m, (name, side) in enumerate(maps):
        z, contrast = normalised(support(name, side), support("counts", side), side, config)
        focus[:used, m] = to_bytes(z, FOCUS)
        context.append(contrast)
    moved = displacement_px(facts)
    context += [moved[0], moved[1], np.hypot(moved[0], moved[1]), np.full((h, w), used / depth)]
    return focus, to_bytes(np.stack(context), CONTEXT)
