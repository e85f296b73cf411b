"""The network's input a second time: in numpy's integers from docs/integer_model.md alone, and in floats as it is meant.

The integers must give the library's bytes; the floats say how far fixed point is from the formulas.
Cells are uint16 [gradient_x, gradient_y, squares, counts][K, h, w].
"""
import math

import numpy as np

from egofocus_training.focus_input import parse_maps, thousandths
from egofocus_training.units import CONTEXT, FOCUS

_MAPS = {"gradient": (0, 1), "gradient_x": (0,), "gradient_y": (1,), "squares": (2,)}


def cell_sums(planes):
    """The cells of counts [K, height, width]."""
    image = planes.astype(np.int64)
    gx, gy = np.zeros_like(image), np.zeros_like(image)
    gx[:, :, 1:-1] = (image[:, :, 2:] - image[:, :, :-2]) ** 2
    gy[:, 1:-1] = (image[:, 2:] - image[:, :-2]) ** 2
    pixels = np.stack([gx, gy, image * (image - 1), image])
    pixels = np.pad(pixels, ((0, 0), (0, 0), (0, -image.shape[1] % 4), (0, -image.shape[2] % 4)))
    m, k, height, width = pixels.shape
    sums = pixels.reshape(m, k, height // 4, 4, width // 4, 4).sum(axis=(3, 5))
    return np.minimum(sums, 65535).astype(np.uint16)


def support(cells, side):
    """Two boxes of side x side cells, zero outside: int64."""
    out, reach = cells.astype(np.int64), side // 2
    for _ in range(2):
        for axis in (-1, -2):
            edge = [(0, 0)] * out.ndim
            edge[axis] = (reach, reach)
            padded, length = np.pad(out, edge), out.shape[axis]
            out = sum(np.take(padded, range(i, i + length), axis) for i in range(side))
    return out


def supported(cells, name, side):
    return support(sum(cells[i].astype(np.int64) for i in _MAPS[name]), side)


# --- integers ------------------------------------------------------------------------------------------------------

_LOG2 = np.array([math.floor(256 * math.log2(1 + (i + 0.5) / 256) + 0.5) for i in range(256)])


def floor_root(values):
    """Floor of the square root of int64 below 2^52."""
    root = np.sqrt(values.astype(np.float64)).astype(np.int64)
    root -= root * root > values
    return root + ((root + 1) ** 2 <= values)


def bit_width(values):
    return np.frexp(np.asarray(values).astype(np.float64))[1].astype(np.int64)


def log2_q8(values):
    width = bit_width(values)
    mantissa = np.where(width > 9, values >> np.maximum(width - 9, 0), values << np.maximum(9 - width, 0))
    return (width - 1) * 256 + _LOG2[mantissa - 256]


def log_steps(above, below):
    return (log2_q8(above) - log2_q8(below) + 16) >> 5


def as_bytes(steps):
    return np.clip(64 + steps, 0, 127).astype(np.uint8)


def support_constants(side, floor_events_milli):
    """a, b, F, c, N, g"""
    a, b = {1: (15, 15), 3: (8, 9), 5: (5, 6), 7: (3, 4)}[side]
    n = 16 * side ** 4
    floor = (n * 2 ** b * floor_events_milli + 500) // 1000
    c = min(30 + floor.bit_length(), 45 + b - a)
    ratio_bits = a + c - 32 - b
    top, bottom = (1, 1) if side == 1 else (4 * side ** 2, 9)
    for g in range(5, -20, -1):
        noise = top * 2 ** (2 * ratio_bits + 2 + b + 2 * g) // bottom
        if noise // floor < 2 ** 32:
            return a, b, floor, c, noise, g
    raise AssertionError("no g")


def integer_sharpness(energy, counts, side, floor_events_milli, floor_noise_milli):
    """(z [K, h, w], contrast [h, w]) in steps."""
    k = len(counts)
    a, b, floor, c, noise, g = support_constants(side, floor_events_milli)
    reciprocal = 2 ** c // (counts * 2 ** b + floor)
    ratio = np.minimum((energy * 2 ** a).astype(np.uint64) * reciprocal.astype(np.uint64) >> np.uint64(32), 2 ** 26 - 2 ** 13).astype(np.int64)
    mean = (ratio.sum(axis=0) + k // 2) // k
    d = np.abs(ratio - mean)
    h = np.maximum(bit_width(d.max(axis=0)) - 13, 0)
    u = np.minimum((d + (1 << h) // 2) >> h, 8191)
    sd = 4 * floor_root(64 * (u * u).sum(axis=0) // k)
    q = floor_root(noise // (counts.sum(axis=0) * 2 ** b // k + floor)) << (5 - g)
    floor_noise = (floor_noise_milli * 2 ** 20 + 500) // 1000
    divisor = sd + (((q * floor_noise + 2 ** 19) >> 20) >> h)
    e = np.maximum(16 - bit_width(divisor), 0)
    gain = np.minimum(2 ** 31 // (divisor << e), 65535)
    limited = np.minimum(u, np.minimum(divisor >> 2, 8191)) << e
    steps = ((limited * gain >> 16) + 64) >> 7
    return np.where(ratio < mean, -steps, steps), log_steps((sd << h) + q, q)


def displacement_px(facts):
    """What one hypothesis more moves at each cell's centre: x [w], y [h], in px."""
    width, height, fx, fy, cx, cy = facts["grid"]
    x, y, z = (c * facts["step_per_m"] for c in facts["baseline_m"])
    u = 4 * np.arange((width + 3) // 4) + 1.5
    v = 4 * np.arange((height + 3) // 4) + 1.5
    return fx * x - z * (u - cx), fy * y - z * (v - cy)


def integer_input(cells, facts, config, depth):
    """The library's (focus, context) of cells [4, K, h, w]; D = depth."""
    used, (h, w) = cells.shape[1], cells.shape[2:]
    milli = thousandths(config.floor_events), thousandths(config.floor_noise)
    maps = parse_maps(config.maps)
    counts = {side: support(cells[3], side) for side in {1, 7, *(side for _, side in maps)}}
    focus = np.zeros((depth, len(maps), h, w), np.int64)
    context = [log_steps(used * side ** 4 + counts[side].sum(axis=0), np.int64(used * side ** 4)) for side in (1, 7)]
    for m, (name, side) in enumerate(maps):
        focus[:used, m], contrast = integer_sharpness(supported(cells, name, side), counts[side], side, *milli)
        context.append(contrast)
    shifts = [np.nan_to_num(px, nan=0.0) for px in displacement_px(facts)]
    q8 = [np.sign(px) * np.floor(np.minimum(np.abs(px) * 256, 32767) + 0.5) for px in shifts]
    dx, dy = np.broadcast_arrays(q8[0].astype(np.int64)[None, :], q8[1].astype(np.int64)[:, None])
    for value in (dx, dy, floor_root(dx * dx + dy * dy)):
        context.append(np.sign(value) * ((np.abs(value) + 4) >> 3))
    context.append(np.full((h, w), (64 * used + depth) // (2 * depth)))
    return as_bytes(focus), as_bytes(np.stack(context))


# --- floats --------------------------------------------------------------------------------------------------------


def float_sharpness(energy, counts, side, config):
    """(z, log2(1 + sd / q) / 4)"""
    n = 16.0 * side ** 4
    ratio = energy / (counts + n * config.floor_events)
    deviation = ratio - ratio.mean(axis=0)
    sd = np.sqrt((deviation ** 2).mean(axis=0))
    m = (6.0 * side) ** 2 if side > 1 else 16.0
    q = np.sqrt(4 / (m * (counts.mean(axis=0) / n + config.floor_events)))
    return deviation / (sd + config.floor_noise * q), np.log2(1 + sd / q) / 4


def float_input(cells, facts, config, depth):
    """What the bytes of integer_input() mean, in steps from 64, neither rounded nor saturated."""
    used, (h, w) = cells.shape[1], cells.shape[2:]
    maps = parse_maps(config.maps)
    focus = np.zeros((depth, len(maps), h, w))
    context = [np.log2(1 + support(cells[3], side).mean(axis=0) / side ** 4) / 4 for side in (1, 7)]
    for m, (name, side) in enumerate(maps):
        focus[:used, m], contrast = float_sharpness(supported(cells, name, side), support(cells[3], side), side, config)
        context.append(contrast)
    dx, dy = np.broadcast_arrays(displacement_px(facts)[0][None, :], displacement_px(facts)[1][:, None])
    context += [dx, dy, np.hypot(dx, dy), np.full((h, w), used / depth)]
    return focus / FOCUS, np.stack(context) / CONTEXT
