"""The picture of one window: panels where they belong, and programs that refuse what they cannot draw."""
import numpy as np
import small_world

from egofocus_training import strip
from egofocus_training.config import Config, InputConfig
from egofocus_training.model.network import FocusNetwork
from egofocus_training.samples import Shard


def test_colours_and_grey():
    picture = strip.colours(np.array([[0.0, 1.0, np.nan]]), 0, 1)
    assert picture[0, 2].tolist() == [0, 0, 0] and picture[0, 1, :2].min() > 200 > picture[0, 0].max()
    assert strip.grey(np.array([[0, 1], [0, 1]]))[..., 0].tolist() == [[0, 255], [0, 255]]


def test_panels(tmp_path):
    folder = small_world.write_shards(tmp_path / "shards", [[small_world.record(2.0)]])
    config = Config(input=InputConfig(hypotheses=16, span_px=16.0))
    config.network.widths, config.network.blocks = [16, 16, 16], [0, 0, 0]
    network = FocusNetwork(config.input, config.network).eval()
    facts, events, truth = strip.window_of_sample(folder / "shard_000000.egs", 0, config)
    assert events.sum() == (Shard(folder / "shard_000000.egs")[0].t_us >= facts["begin_us"]).sum()
    picture = strip.render(network, config, facts, events, truth)
    height, width = events.shape
    assert picture.shape == (2 * (height + 14) + 150, 3 * width, 3)
    assert np.array_equal(picture[14:14 + height, :width], strip.grey(events))
    truth_panel = picture[14 + height + 14:2 * (14 + height), :width]
    expected = strip.colours(np.full((height, width), truth[40, 48]), 0, 15)
    assert np.mean(np.all(truth_panel == expected, axis=2)) > 0.9  # all but the marks
