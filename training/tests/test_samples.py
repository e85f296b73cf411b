"""The reader of shards: every field where the layout puts it, and one clear message for what is no shard."""
import os
import pathlib
import struct
import subprocess

import numpy as np
import pytest
import small_world

from egofocus_training.errors import BAD_FILE, FILE, TrainingError
from egofocus_training.samples import Shard, find_shards, parse_sample, split_shards
from egofocus_training.config import DataConfig


def refusal(call):
    with pytest.raises(TrainingError) as caught:
        call()
    return caught.value.exit_code, str(caught.value)


def test_every_field():
    record = small_world.record(2.0, seed=77, coefficients=(0.1, 0.2, 0.3, 0.4, 0.5), distortion=1, z_near_m=0.7)
    s = parse_sample(record, "here")
    assert (s.seed, s.at_us, s.family, s.night, s.window_us, s.z_near_m) == (77, 5_000_000, "room", False, 200000, 0.7)
    assert s.camera.grid() == (96, 80, 80.0, 80.0, 47.5, 39.5)
    assert s.camera.distortion == 1 and s.camera.coefficients.tolist() == [0.1, 0.2, 0.3, 0.4, 0.5]
    assert s.motion_t_us.tolist() == list(range(-200000, 1, 10000))
    assert s.velocity_m_s.tolist() == [[1, 0, 0]] * 21 and not s.rate_rad_s.any()
    n = s.t_us.size
    assert n > 5000 and s.x.size == s.y.size == s.polarity.size == n
    assert s.polarity[:4].tolist() == [0, 1, 0, 1] and s.y.max() < 80
    assert np.allclose(s.inverse_depth, 0.5, rtol=1e-4)
    assert s.moving.sum() == 16 and s.moving[3, 3] and not s.moving[4, 4]


def test_a_shard_and_its_damage(tmp_path):
    records = [small_world.record(2.0, seed=5), small_world.record(3.0, seed=6)]
    path = tmp_path / "shard_000000.egs"
    whole = small_world.shard_bytes(records)
    path.write_bytes(whole)
    shard = Shard(path)
    assert len(shard) == 2 and shard.world(1) == 6 and shard[1].seed == 6
    for damaged, code, words in ((whole[:-1], BAD_FILE, "ends inside the record"), (b"", FILE, "cannot be read"),
                                 (whole[:10], BAD_FILE, "ends inside"), (b"EGSHARD9" + whole[8:], BAD_FILE, "is no shard")):
        path.write_bytes(damaged)
        assert refusal(lambda: Shard(path))[0] == code
        assert words in refusal(lambda: Shard(path))[1]
    assert refusal(lambda: Shard(tmp_path / "none.egs"))[0] == FILE


def test_windows_of_a_second(tmp_path):
    path = tmp_path / "shard_000000.egs"
    path.write_bytes(small_world.shard_bytes([small_world.record(2.0, motions=101)], b"EGSHARD2"))
    sample = Shard(path)[0]
    assert sample.motion_t_us.tolist() == list(range(-1000000, 1, 10000)) and sample.velocity_m_s.shape == (101, 3)


@pytest.mark.parametrize("at, value, words", [
    (20, struct.pack("<H", 5), "5x80 px"),  # width: the size no longer fits
    (18, b"\x09", "make no sense"),  # family, after seed and time: byte 16; night 17
    (100 + 16, struct.pack("<I", 0xFFFFFFFF), "events make"),
    (24, struct.pack("<d", float("nan")), "make no sense"),
])
def test_damaged_records(at, value, words):
    record = bytearray(small_world.record(2.0))
    at = {18: 16, 20: 18, 116: 24 + 80 + 4}.get(at, at)
    record[at:at + len(value)] = value
    code, message = refusal(lambda: parse_sample(bytes(record), "shard 3, sample 4"))
    assert code == BAD_FILE and words in message and "shard 3, sample 4" in message


def test_events_outside_the_sensor_and_times_that_fall():
    record = small_world.record(2.0)
    head = 24 + 80 + 8 + 21 * 28
    outside = bytearray(record)
    outside[head + 4:head + 6] = struct.pack("<H", 96)
    assert "outside the sensor" in refusal(lambda: parse_sample(bytes(outside), "x"))[1]
    falling = bytearray(record)
    falling[head:head + 4] = struct.pack("<i", 0)
    assert "times" in refusal(lambda: parse_sample(bytes(falling), "x"))[1]
    assert "head alone" in refusal(lambda: parse_sample(b"123", "x"))[1]


def test_splits(tmp_path):
    a = small_world.write_shards(tmp_path / "a", [[small_world.record(2.0)]] * 5)
    train, validation = split_shards(DataConfig(train=[str(a)], hold_out_every=3))
    assert [p.name[6:12] for p in validation] == ["000000", "000003"]
    assert [p.name[6:12] for p in train] == ["000001", "000002", "000004"]
    code, message = refusal(lambda: find_shards([str(tmp_path)]))
    assert code == FILE and "citysim samples" in message
    assert refusal(lambda: split_shards(DataConfig(train=[str(a)], hold_out_every=1)))[0] == FILE


def citysim():
    """The program, of whichever build."""
    build = pathlib.Path(__file__).resolve().parents[2] / "build"
    places = [os.environ.get("EGOFOCUS_CITYSIM", "")] + [build / name / "tools/citysim/citysim" for name in ("release", "training", "dev")]
    found = [str(place) for place in places if os.access(place, os.X_OK)]
    return found[0] if found else None


@pytest.mark.skipif(citysim() is None, reason="citysim was not built")
def test_what_citysim_writes(tmp_path):
    subprocess.run([citysim(), "samples", "--out", str(tmp_path), "--count", "1", "--size", "64x64",
                    "--families", "desk", "--seed", "3"], check=True, capture_output=True)
    shard = Shard(tmp_path / "shard_000000.egs")
    assert len(shard) == 64 and len({shard.world(i) for i in range(64)}) == 8
    for i in range(0, 64, 9):
        sample = shard[i]
        assert sample.family == "desk" and sample.inverse_depth.shape == (64, 64)
        assert sample.t_us.size and sample.t_us[0] >= -sample.window_us and np.linalg.norm(sample.velocity_m_s) > 0
