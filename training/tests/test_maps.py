"""Depth maps of a recording: scale, times, and windows that have no answer."""
import pathlib
import tomllib

import numpy as np
import pytest
from PIL import Image

from egofocus_training.config import Config
from egofocus_training.errors import BAD_FILE, FILE, TrainingError
from egofocus_training.maps import camera_numbers, depth_picture, write_maps

PLANES = pathlib.Path(__file__).resolve().parents[2] / "fixtures" / "planes"


def test_pictures_by_hand():
    picture = depth_picture(np.array([[0.0, 1.0, 2.5, 1e-9, 40.0, -3.0]]), step_per_m=0.1, scale_m=0.001)
    assert picture.dtype == np.uint16 and picture.tolist() == [[65535, 10000, 4000, 65535, 250, 65535]]


def test_the_fixture_has_a_map_for_each_truth(tmp_path):
    config = Config()
    config.input.maps = ["gradient:3"]
    seen = []

    def index_of(facts):
        seen.append(facts["step_per_m"])
        return np.full((180, 240), 1 / (2.0 * facts["step_per_m"]))  # 2 m everywhere

    maps, empty = write_maps(index_of, PLANES, tmp_path / "planes", config)
    truths = {path.stem for path in (PLANES / "depth").glob("*.png")}
    assert {path.stem for path in (tmp_path / "planes").glob("*.png")} == truths and maps == len(truths)
    assert 10 < empty < maps and len(seen) == maps - empty  # it stands still for a while
    scale_m = tomllib.loads((PLANES / "camera.toml").read_text())["depth"]["scale_m"]
    assert camera_numbers(PLANES)[1] == scale_m
    values = set()
    for path in (tmp_path / "planes").glob("*.png"):
        values |= set(np.unique(np.asarray(Image.open(path))).tolist())
    assert values == {0, round(2.0 / scale_m)}


def test_what_is_missing_is_named(tmp_path):
    with pytest.raises(TrainingError, match="camera.toml") as caught:
        write_maps(None, tmp_path, tmp_path / "out", Config())
    assert caught.value.exit_code == FILE
    (tmp_path / "camera.toml").write_text("[camera")
    with pytest.raises(TrainingError, match="is not TOML") as caught:
        camera_numbers(tmp_path)
    assert caught.value.exit_code == BAD_FILE
