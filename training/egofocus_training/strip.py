"""python3 -m egofocus_training.strip --config FILE --weights FILE --out PNG [--shard FILE --sample N | --at-us T]: one window,
seen as data.

Panels: events as they came; the image of warped events, each pixel at its predicted hypothesis; depth, truth, error (bins of the
ladder), confidence; below, scores over hypotheses at four pixels, with truth (green) and estimate (red). Without a shard, the
config's [recording]; --at-us defaults to its reference's time.
"""
import argparse

import numpy as np
import torch

from . import errors, library
from .config import load_config
from .dataset import collate
from .evaluate import load_network
from .metrics import enlarge
from .model.regression import distribution
from .recordings import reference_of
from .samples import Shard
from .windows import ladder_of, network_inputs, recording_facts, sample_facts


def colours(values, low, high):
    """[h, w] -> u8 [h, w, 3], dark blue over green to yellow; unknown (nan) is black."""
    share = np.clip((values - low) / (high - low), 0, 1)
    known = np.isfinite(values)
    share = np.where(known, share, 0)
    red = np.clip(2 * share - 0.8, 0, 1)
    green = 0.1 + 0.85 * share
    blue = np.clip(0.45 + 0.5 * share - 1.2 * share ** 2, 0, 1)
    return (np.stack([red, green, blue], 2) * known[..., None] * 255).astype(np.uint8)


def grey(counts):
    """Counts, up to their 99th percentile, white on black."""
    most = max(np.percentile(counts, 99), 1)
    return (np.clip(counts / most, 0, 1)[..., None] * np.ones(3) * 255).astype(np.uint8)


def window_of_sample(path, number, config):
    """(facts, events [h, w], truth's index [h, w])"""
    sample = Shard(path)[number]
    facts = sample_facts(sample, config, ("counts",))
    events = np.zeros((sample.camera.height, sample.camera.width))
    recent = sample.t_us >= facts["begin_us"]
    np.add.at(events, (sample.y[recent], sample.x[recent]), 1)
    return facts, events, sample.inverse_depth / max(facts["step_per_m"], 1e-12)


def window_of_recording(config, at_us):
    place = config.recording
    recording = library.stack.Recording(place.folder, place.source or None, ladder_of(config.input, place.z_near_m))
    references = dict(reference_of(recording, place))
    at_us = at_us if at_us is not None else next(iter(references), 0)
    facts = recording_facts(recording, at_us, config, ("counts",))
    width, height = facts["grid"][:2]
    t_us, x, y, _ = recording.events(at_us)
    events = np.zeros((height, width))
    recent = (t_us >= facts["begin_us"]) & (x < width) & (y < height)
    np.add.at(events, (y[recent], x[recent]), 1)
    truth_m = references.get(at_us, np.zeros((height, width)))
    with np.errstate(divide="ignore"):
        index = np.where(truth_m > 0, 1 / truth_m, np.nan) / max(facts["step_per_m"], 1e-12)
    return facts, events, index


@torch.no_grad()
def render(network, config, facts, events, truth):
    """The picture, u8 [height, width, 3]."""
    from PIL import Image, ImageDraw

    inputs = collate([network_inputs(facts, config.network.order)])
    prediction = network(inputs)
    p = distribution(prediction.scores, inputs["used"])[0].numpy()
    height, width = events.shape
    index = enlarge(prediction.index[0].float().numpy(), height, width)
    nearest = np.clip(np.rint(index).astype(int), 0, facts["hypotheses"] - 1)
    focused = np.take_along_axis(facts["counts"], nearest[None], 0)[0]
    trust = np.kron(prediction.confidence[0].float().numpy(), np.ones((4, 4)))[:height, :width]
    top = facts["hypotheses"] - 1
    panels = [("events", grey(events)), ("warped at the estimate", grey(focused)), ("inverse depth", colours(index, 0, top)),
              ("truth", colours(truth, 0, top)), ("error, 0 to 5 bins", colours(np.abs(index - np.clip(truth, 0, top)), 0, 5)),
              ("confidence", colours(trust, 0, 1))]
    chart = 150
    picture = Image.new("RGB", (3 * width, 2 * (height + 14) + chart), "white")
    draw = ImageDraw.Draw(picture)
    for n, (name, pixels) in enumerate(panels):
        at = (n % 3 * width, n // 3 * (height + 14))
        picture.paste(Image.fromarray(pixels), (at[0], at[1] + 14))
        draw.text((at[0] + 2, at[1] + 1), name, fill="black")
    places = [(height // 4, width // 4), (height // 4, 3 * width // 4), (3 * height // 4, width // 4), (3 * height // 4, 3 * width // 4)]
    for n, (y, x) in enumerate(places):
        left, base, span = n * 3 * width // 4 + 8, 2 * (height + 14) + chart - 12, 3 * width // 4 - 20
        curve = p[:facts["hypotheses"], y // 4, x // 4]

        def at(k, value):
            return left + span * k / max(top, 1), base - (chart - 34) * value / max(curve.max(), 1e-9)

        draw.line([at(k, value) for k, value in enumerate(curve)], fill="black")
        for mark, colour in ((truth[y, x], "green"), (index[y, x], "red")):
            if np.isfinite(mark):
                draw.line([at(min(mark, top), 0), at(min(mark, top), curve.max())], fill=colour)
        draw.text((left, base - chart + 14), f"p over hypotheses at ({x}, {y})", fill="black")
        for panel in (2, 3):
            u, v = panel % 3 * width + x, panel // 3 * (height + 14) + 14 + y
            draw.rectangle([u - 2, v - 2, u + 2, v + 2], outline="white")
    return np.asarray(picture)


def main():
    parser = argparse.ArgumentParser(prog="egofocus_training.strip", description=__doc__)
    parser.add_argument("--config", required=True)
    parser.add_argument("--weights", required=True)
    parser.add_argument("--out", required=True)
    parser.add_argument("--shard")
    parser.add_argument("--sample", type=int, default=0)
    parser.add_argument("--at-us", type=int)
    arguments = parser.parse_args()
    config = load_config(arguments.config)
    network = load_network(arguments.weights, config)
    if arguments.shard:
        if not 0 <= arguments.sample < len(Shard(arguments.shard)):
            raise errors.TrainingError(errors.USAGE, "--sample", f"{arguments.shard} has {len(Shard(arguments.shard))} samples.")
        window = window_of_sample(arguments.shard, arguments.sample, config)
    elif config.recording.folder:
        try:
            window = window_of_recording(config, arguments.at_us)
        except library.stack.StackError as error:
            raise errors.TrainingError(errors.FILE, config.recording.folder, str(error)) from None
    else:
        raise errors.TrainingError(errors.USAGE, "--shard", "is missing, and the config names no [recording].")
    if not window[0]["has_stack"]:
        raise errors.TrainingError(errors.USAGE, arguments.shard or config.recording.folder, "no parallax in this window.")
    from PIL import Image

    try:
        Image.fromarray(render(network, config, *window)).save(arguments.out)
    except OSError as error:
        raise errors.TrainingError(errors.FILE, arguments.out, f"cannot be written ({error}).") from None
    return 0


if __name__ == "__main__":
    errors.run(main)
