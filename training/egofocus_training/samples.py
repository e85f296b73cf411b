"""Samples of `citysim samples`: shards on disk, layout in tools/citysim/README.md, "Samples"."""
import mmap
import pathlib
import struct
from dataclasses import dataclass

import numpy as np

from .errors import BAD_FILE, FILE, TrainingError

FAMILIES = ("town1", "town2_night", "town3", "town4", "town5_night", "room", "desk", "corridor")
MOTIONS = {b"EGSHARD1": 21, b"EGSHARD2": 101}  # of a window, by the format of its shard: over 0.2 s and 1 s
_HEAD = struct.Struct("<QqBBHHH10diI")  # to the number of events
_MOTION = np.dtype([("t_us", "<i4"), ("velocity_m_s", "<f4", 3), ("rate_rad_s", "<f4", 3)])
_EVENT = np.dtype([("t_us", "<i4"), ("x", "<u2"), ("y_polarity", "<u2")])


@dataclass
class Camera:
    """Pinhole part, which is also the working grid, and the distortion of the sensor."""
    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    distortion: int  # 0 none, 1 plumb-bob, 2 equidistant
    coefficients: np.ndarray  # [5]

    def grid(self):
        return (self.width, self.height, self.fx, self.fy, self.cx, self.cy)


@dataclass
class Sample:
    """One window. Times count back from its end, about which the truth is."""
    seed: int
    at_us: int
    family: str
    night: bool
    camera: Camera
    z_near_m: float
    window_us: int
    motion_t_us: np.ndarray  # [motions]
    velocity_m_s: np.ndarray  # [motions, 3], camera frame
    rate_rad_s: np.ndarray  # [motions, 3]
    t_us: np.ndarray  # [n] <= 0
    x: np.ndarray  # [n] distorted pixels
    y: np.ndarray
    polarity: np.ndarray  # [n] 1: ON
    inverse_depth: np.ndarray  # [height, width] 1/m, 0: the sky
    moving: np.ndarray  # [height, width] bool


def parse_sample(record, where, motions=21):
    """The sample of a record's bytes; TrainingError (BAD_FILE) when they are not one."""
    def bad(what):
        return TrainingError(BAD_FILE, where, f"{what}. Delete the shard; `citysim samples` makes it again.")

    if len(record) < _HEAD.size:
        raise bad(f"the record has {len(record)} bytes, its head alone {_HEAD.size}")
    (seed, at_us, family, night, width, height, distortion, fx, fy, cx, cy, *more, window_us, n) = _HEAD.unpack_from(record)
    coefficients, z_near_m = np.array(more[:5]), more[5]
    pixels = width * height
    expected = _HEAD.size + motions * _MOTION.itemsize + n * _EVENT.itemsize + 4 + 3 * pixels
    if len(record) != expected:
        raise bad(f"the record has {len(record)} bytes; {width}x{height} px and {n} events make {expected}")
    numbers = (fx, fy, cx, cy, z_near_m, *coefficients)
    if family >= len(FAMILIES) or distortion > 2 or not np.all(np.isfinite(numbers)) or min(fx, fy, z_near_m) <= 0:
        raise bad("family, camera or z_near make no sense")
    at = _HEAD.size
    motion = np.frombuffer(record, _MOTION, motions, at)
    at += motion.nbytes
    events = np.frombuffer(record, _EVENT, n, at)
    at += events.nbytes
    (step,) = struct.unpack_from("<f", record, at)
    codes = np.frombuffer(record, "<u2", pixels, at + 4)
    moving = np.frombuffer(record, "u1", pixels, at + 4 + codes.nbytes)
    y_polarity = events["y_polarity"]
    sample = Sample(seed, at_us, FAMILIES[family], bool(night),
                    Camera(width, height, fx, fy, cx, cy, distortion, coefficients), z_near_m, window_us,
                    motion["t_us"].copy(), motion["velocity_m_s"].copy(), motion["rate_rad_s"].copy(),
                    events["t_us"].copy(), events["x"].copy(), y_polarity & 0x7FFF, (y_polarity >> 15).astype(np.uint8),
                    (codes.astype(np.float32) * np.float32(step)).reshape(height, width),
                    (moving != 0).reshape(height, width))
    rising = n == 0 or (np.all(np.diff(sample.t_us) >= 0) and sample.t_us[-1] <= 0)
    if not rising or not np.all(np.diff(sample.motion_t_us) > 0) or not np.isfinite(step) or step <= 0:
        raise bad("times or the depth's step make no sense")
    if n and (sample.x.max() >= width or sample.y.max() >= height):
        raise bad("an event lies outside the sensor")
    return sample


class Shard:
    """A shard's records, mapped. TrainingError: FILE when it cannot be read, BAD_FILE when it is cut short."""

    def __init__(self, path):
        self.path = pathlib.Path(path)
        try:
            with open(self.path, "rb") as file:
                self._bytes = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        except (OSError, ValueError) as error:
            raise TrainingError(FILE, self.path, f"cannot be read ({error}).") from None
        self._motions = MOTIONS.get(self._bytes[:8])
        if self._motions is None:
            raise TrainingError(BAD_FILE, self.path, f"is no shard: it begins with none of {', '.join(m.decode() for m in MOTIONS)}.")
        self._records = []
        at = 8
        while at < len(self._bytes):
            if at + 4 > len(self._bytes):
                self._cut(at)
            (size,) = struct.unpack_from("<I", self._bytes, at)
            at += 4
            if size > len(self._bytes) - at:
                self._cut(at)
            self._records.append((at, size))
            at += size

    def _cut(self, at):
        raise TrainingError(BAD_FILE, self.path, f"ends inside the record at byte {at}. "
                            "Delete the shard; `citysim samples` makes it again.")

    def __len__(self):
        return len(self._records)

    def _head(self, index):
        at, size = self._records[index]
        if size < _HEAD.size:
            raise TrainingError(BAD_FILE, f"{self.path}, sample {index}", "is too short to be a sample.")
        return _HEAD.unpack_from(self._bytes, at)

    def world(self, index):
        """Seed of the sample's world, without reading the rest."""
        return self._head(index)[0]

    def family(self, index):
        """Number of the sample's family in FAMILIES, the same way."""
        return self._head(index)[2]

    def __getitem__(self, index):
        at, size = self._records[index]
        return parse_sample(self._bytes[at:at + size], f"{self.path}, sample {index}", self._motions)


def find_shards(folders):
    """The shards of some folders, in the order of folders and names. TrainingError (FILE) where there is none."""
    paths = []
    for folder in folders:
        found = sorted(pathlib.Path(folder).glob("shard_*.egs"))
        if not found:
            raise TrainingError(FILE, folder, "holds no shards. Make some: citysim samples --out FOLDER --count N")
        paths += found
    return paths


def split_shards(data):
    """(training shards, validation shards) of a DataConfig. Worlds are never shared between shards."""
    train = find_shards(data.train)
    validation = find_shards(data.validation) if data.validation else []
    if data.hold_out_every > 0:
        held = train[::data.hold_out_every]
        train = [path for i, path in enumerate(train) if i % data.hold_out_every]
        validation = held + validation
    if not train:
        raise TrainingError(FILE, ", ".join(data.train), "no shard is left to train on. Make more, or hold out fewer.")
    return train, validation
