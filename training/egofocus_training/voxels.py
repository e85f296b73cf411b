"""Voxel grids, for networks that are not told where events would lie at each depth (model/recurrent.py).

The window is cut into T slices of equal time, each with B bins. An event of polarity s = +-1 at pixel x gives
    V(b, x) += s max(0, 1 - |b - (B - 1) r|)        r: its place in the slice, 0..1
at the pixel of the grid that its undistorted ray is nearest to. As bytes: V / sd in steps of 1/16, sd over the window's values
other than 0.
"""
import numpy as np

MOTIONS = 8  # numbers of motion_of_slices()
STEP = 1 / 16  # of what one byte says, in standard deviations


def voxel_grids(t_us, cell, polarity, begin_us, slices, bins, pixels):
    """V, float32 [slices, bins, pixels]. Events [n] with begin_us <= t_us <= 0 count; cell: pixel of the grid, -1 outside."""
    inside = (t_us >= begin_us) & (cell >= 0)
    place = (t_us[inside] - begin_us) * (slices / -begin_us)
    part = np.minimum(place.astype(np.int64), slices - 1)
    r = (place - part) * (bins - 1)
    low = np.minimum(r.astype(np.int64), bins - 2)
    at = (part * bins + low) * pixels + cell[inside]
    sign = np.where(polarity[inside] > 0, 1.0, -1.0)
    high_share = sign * (r - low)
    size = slices * bins * pixels
    grid = np.bincount(at, sign - high_share, size)
    grid[pixels:] += np.bincount(at, high_share, size)[:-pixels]
    return grid.astype(np.float32).reshape(slices, bins, pixels)


def voxel_bytes(grid):
    """int8 of a voxel grid, as above."""
    hit = grid[grid != 0]
    scale = 1 / (STEP * max(float(np.sqrt(np.mean(hit * hit))), 1e-6)) if hit.size else 0.0
    return np.clip(np.rint(grid * scale), -127, 127).astype(np.int8)


def motion_of_slices(t_us, velocity_m_s, rate_rad_s, begin_us, slices, step_per_m, focal_px):
    """What is measured at the middle of each slice, float32 [slices, 8]: how far it would move the window's images, in px per
    hypothesis (x, y, z) and by turning (x, y, z, in 16 px); ln of the ladder's step (1/m) and of the window's length (s)."""
    middle_us = begin_us * (1 - (np.arange(slices) + 0.5) / slices)
    length_s = -begin_us * 1e-6
    out = np.empty((slices, MOTIONS), np.float32)
    for axis in range(3):
        out[:, axis] = np.interp(middle_us, t_us, velocity_m_s[:, axis]) * length_s * step_per_m * focal_px
        out[:, 3 + axis] = np.interp(middle_us, t_us, rate_rad_s[:, axis]) * length_s * focal_px / 16
    out[:, 6:] = np.log(step_per_m), np.log(length_s)
    return out


def rays_of(grid, side):
    """x/z and y/z of the centres of cells of side x side pixels: float32 [2, h, w]. grid: width, height, fx, fy, cx, cy."""
    width, height, fx, fy, cx, cy = grid
    x = (side * np.arange(-(-width // side)) + (side - 1) / 2 - cx) / fx
    y = (side * np.arange(-(-height // side)) + (side - 1) / 2 - cy) / fy
    return np.stack(np.broadcast_arrays(x[None], y[:, None])).astype(np.float32)


def recurrent_inputs(config, facts, events, motion, cell):
    """slices int8 [T, B, h, w], motion float32 [T, 8], rays float32 [2, h/2, w/2] of a window with a ladder.

    config: a RecurrentConfig; facts: the binding's; events: t_us, polarity; motion: t_us, velocity_m_s, rate_rad_s; cell: of
    each event, as voxel_grids()."""
    width, height, focal_px = facts["grid"][:3]
    grid = voxel_grids(events[0], cell, events[1], facts["begin_us"], config.slices, config.bins, width * height)
    return {"slices": voxel_bytes(grid).reshape(config.slices, config.bins, height, width),
            "motion": motion_of_slices(*motion, facts["begin_us"], config.slices, facts["step_per_m"], focal_px),
            "rays": rays_of(facts["grid"], 2)}
