"""Shards made here, byte by byte from the layout in tools/citysim/README.md, of a world that can be drawn by hand: a wall
of points in front of a camera that slides to the right. Each point fires all the time."""
import struct

import numpy as np

# A network that learns nothing useful, quickly, from `shards` beside its file. {} takes further lines of [train] and sections.
CONFIG = """
[data]
train = ["shards"]
hold_out_every = 2
[input]
hypotheses = 16
span_px = 16.0
maps = ["gradient:3", "squares:7"]
[network]
widths = [16, 16, 16]
blocks = [1, 0, 1]
up_blocks = [1, 1]
refine_width = 8
refine_dilations = [1]
[augment]
crop = [48, 64]
[train]
batch = 2
workers = 0
{}
"""

WIDTH, HEIGHT, FOCAL = 96, 80, 80.0
SPEED_M_S, WINDOW_US = 1.0, 200000
TOWN1, ROOM = 0, 5


def record(depth_m, seed=1, family=ROOM, points=400, near=None, z_near_m=1.0, coefficients=(0, 0, 0, 0, 0), distortion=0,
           motions=21):
    """One sample: a wall at depth_m; with near = (x0, x1, metres) those columns of the reference view are nearer."""
    random = np.random.default_rng(seed)
    depth = np.full((HEIGHT, WIDTH), depth_m)
    if near:
        depth[:, near[0]:near[1]] = near[2]
    cx, cy = WIDTH / 2 - 0.5, HEIGHT / 2 - 0.5
    u = random.uniform(0, WIDTH - 1, points)
    v = random.uniform(0, HEIGHT - 1, points)
    z = depth[np.rint(v).astype(int), np.rint(u).astype(int)]
    t_us = np.sort(random.integers(-WINDOW_US, 1, points * 30))
    which = random.integers(0, points, t_us.size)
    # The camera was SPEED * t metres away from where it is at the end.
    x = np.rint(u[which] - FOCAL * SPEED_M_S * t_us * 1e-6 / z[which]).astype(int)
    y = np.rint(v[which]).astype(int)
    inside = (x >= 0) & (x < WIDTH)
    t_us, x, y = t_us[inside], x[inside], y[inside]
    out = struct.pack("<QqBBHHH", seed, 5_000_000, family, 0, WIDTH, HEIGHT, distortion)
    out += struct.pack("<10d", FOCAL, FOCAL, cx, cy, *coefficients, z_near_m)
    out += struct.pack("<iI", WINDOW_US, t_us.size)
    for i in range(motions):
        out += struct.pack("<i6f", 10000 * (i + 1 - motions), SPEED_M_S, 0, 0, 0, 0, 0)
    for e in range(t_us.size):
        out += struct.pack("<iHH", t_us[e], x[e], y[e] | (0x8000 if e % 2 else 0))
    rho = 1 / depth
    step = np.float32(rho.max() / 65535)
    out += struct.pack("<f", step) + np.rint(rho / step).astype("<u2").tobytes()
    moving = np.zeros((HEIGHT, WIDTH), np.uint8)
    moving[:4, :4] = 1
    return out + moving.tobytes()


def shard_bytes(records, magic=b"EGSHARD1"):
    return magic + b"".join(struct.pack("<I", len(r)) + r for r in records)


def write_shards(folder, shards):
    """shards: lists of records."""
    folder.mkdir(parents=True, exist_ok=True)
    for n, records in enumerate(shards):
        (folder / f"shard_{n:06}.egs").write_bytes(shard_bytes(records))
    return folder


def varied_records(count, first_seed=1):
    """Walls between 1.3 and 4 m, half of them with something nearer in front."""
    records = []
    for i in range(count):
        wall = 1.3 + 2.7 * ((7 * i) % count) / count
        near = (20 + 3 * (i % 5), 55, 1.15) if i % 2 and wall > 1.8 else None
        records.append(record(wall, seed=first_seed + i, near=near))
    return records
