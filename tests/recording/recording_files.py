"""A recording's files, read straight from the descriptions of their formats: nothing of the library has a part in it."""
import json
import struct
import zlib

import numpy as np


def read_png16(path):
    """16-bit grey, straight from the PNG specification."""
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed = 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            width, height, depth, colour = struct.unpack(">IIBB", body[:10])
            assert (depth, colour) == (16, 0)
        elif kind == b"IDAT":
            packed += body
        at += 12 + length
    raw = zlib.decompress(packed)
    stride, above, rows = 2 * width, bytearray(2 * width), []
    for y in range(height):
        start = y * (stride + 1)
        kind, line = raw[start], bytearray(raw[start + 1:start + 1 + stride])
        for i in range(stride):
            left = line[i - 2] if i >= 2 else 0
            corner = above[i - 2] if i >= 2 else 0
            if kind == 1:
                line[i] = (line[i] + left) & 255
            elif kind == 2:
                line[i] = (line[i] + above[i]) & 255
            elif kind == 3:
                line[i] = (line[i] + (left + above[i]) // 2) & 255
            elif kind == 4:
                p = left + above[i] - corner
                nearest = min((abs(p - left), 0, left), (abs(p - above[i]), 1, above[i]), (abs(p - corner), 2, corner))
                line[i] = (line[i] + nearest[2]) & 255
        rows.append(np.frombuffer(bytes(line), dtype=">u2"))
        above = line
    return np.stack(rows).astype(np.uint16)


def write_png16(path, values):
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    height, width = values.shape
    lines = b"".join(b"\0" + row.astype(">u2").tobytes() for row in values)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 16, 0, 0, 0, 0)) +
                     chunk(b"IDAT", zlib.compress(lines)) + chunk(b"IEND", b""))


def read_evt3(path):
    """t (us), x, y of all events, straight from the EVT 3.0 format's description; vectors included."""
    data = path.read_bytes()
    data = data[data.index(b"% end\n") + 6:]
    t, x, y = [], [], []
    high = low = row = base = epoch = 0
    for word in np.frombuffer(data[:len(data) // 2 * 2], dtype="<u2").tolist():
        kind, value = word >> 12, word & 0xfff
        if kind == 0x0:
            row = value & 0x7ff
        elif kind == 0x2:
            t.append(epoch + (high << 12) + low)
            x.append(value & 0x7ff)
            y.append(row)
        elif kind == 0x3:
            base = value & 0x7ff
        elif kind in (0x4, 0x5):
            size = 12 if kind == 0x4 else 8
            for bit in range(size):
                if value >> bit & 1:
                    t.append(epoch + (high << 12) + low)
                    x.append(base + bit)
                    y.append(row)
            base += size
        elif kind == 0x6:
            low = value
        elif kind == 0x8:
            if value < high:
                epoch += 1 << 24
            high = value
    return np.array(t), np.array(x), np.array(y)


def grid_of_sensor(recording):
    """Grid pixel (u, v) of each sensor pixel of fixtures/planes: plumb-bob inverted by fixed-point steps."""
    text = (recording / "camera.toml").read_text()
    camera = dict(line.split(" = ", 1) for line in text.split("[grid]")[0].splitlines() if " = " in line)
    fx, fy, cx, cy = (float(camera[key]) for key in ("fx_px", "fy_px", "cx_px", "cy_px"))
    k1, k2, p1, p2, k3 = json.loads(camera["coefficients"])
    v, u = np.mgrid[0:int(camera["height_px"]), 0:int(camera["width_px"])]
    xd, yd = (u - cx) / fx, (v - cy) / fy
    x, y = xd.copy(), yd.copy()
    for _ in range(100):
        r2 = x * x + y * y
        radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
        x, y = ((xd - 2 * p1 * x * y - p2 * (r2 + 2 * x * x)) / radial,
                (yd - p1 * (r2 + 2 * y * y) - 2 * p2 * x * y) / radial)
    return np.floor(x * fx + cx + 0.5).astype(int), np.floor(y * fy + cy + 0.5).astype(int)
