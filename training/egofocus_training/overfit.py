"""python3 -m egofocus_training.overfit --config FILE [--samples 64] [--steps 400] [--json]: can the network learn at all?

Trains on a few samples, in floats and without augmentation, and says how well it knows them: Abs.Rel near 0 shows that inputs,
targets, loss and network belong together. What it learns is thrown away.
"""
import argparse
import json

import torch

from . import errors
from .config import load_config
from .evaluate import evaluate, spread_over, table
from .journal import Progress
from .machine import keep_freed_memory
from .samples import split_shards
from .trainer import Trainer


def overfit(config, samples, steps):
    """(rows of evaluate(), loss at the end)"""
    augment = config.augment
    augment.crop, augment.span = [], [1.0, 1.0]
    augment.flip_horizontal = augment.flip_vertical = augment.event_drop = augment.hot_pixels = 0.0
    augment.velocity_noise = augment.delay_ms = augment.slow = augment.dim = 0.0
    config.data.limit = samples
    config.train.steps, config.train.warmup_steps = steps, max(steps // 20, 1)
    config.train.workers = 0  # a worker would end with each short epoch, and its tables of rays with it
    config.quantise.last_steps = 0
    paths, _ = split_shards(config.data)
    trainer = Trainer(config, lambda: paths)
    progress = Progress("overfit", steps)
    last = {}

    def after_step(terms):
        last.update(terms)
        progress.show(trainer.step, f"loss {terms['loss']:.3f}")

    trainer.run(steps, after_step)
    progress.end()
    rows, _ = evaluate(trainer.average.network, spread_over(paths, samples), config)
    return rows, last["loss"]


def main():
    parser = argparse.ArgumentParser(prog="egofocus_training.overfit", description=__doc__)
    parser.add_argument("--config", required=True)
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--steps", type=int, default=400)
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    if arguments.samples < 1 or arguments.steps < 1:
        raise errors.TrainingError(errors.USAGE, "--samples and --steps", "are positive.")
    keep_freed_memory()
    config = load_config(arguments.config)
    if config.train.threads > 0:
        torch.set_num_threads(config.train.threads)
    rows, loss = overfit(config, arguments.samples, arguments.steps)
    print(json.dumps({"rows": rows, "loss": loss}) if arguments.json else table(rows))
    return 0


if __name__ == "__main__":
    errors.run(main)
