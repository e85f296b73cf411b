"""python3 -m egofocus_training.train --config FILE --out DIR [--resume]: trains, evaluates, keeps checkpoints and curves."""
import argparse
import pathlib
import signal
import sys
import time

import torch

from . import errors
from .config import load_config
from .evaluate import evaluate, spread_over
from .journal import Journal, Progress, draw_curves
from .machine import keep_freed_memory, only_run
from .recordings import evaluate_recording
from .samples import split_shards
from .trainer import CHECKPOINT, Trainer

_CURVES = ["loss", "distribution coarse", "index log_depth", "d1_all d1_events", "abs_rel_all abs_rel_events",
           "idx_mae_all idx_mae_events", "recording_abs_rel recording_median recording_d1"]


class Run:
    """One program's run: what happens between the steps."""

    def __init__(self, config, out, resume, stop_after_s):
        self.config, self.out = config, pathlib.Path(out)
        self.train_paths, validation = split_shards(config.data)
        self.validation = spread_over(validation, config.data.validation_samples) if validation else []
        try:
            self.out.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise errors.TrainingError(errors.FILE, out, f"cannot be made ({error.strerror}).") from None
        self.lock = only_run(self.out)
        exists = (self.out / CHECKPOINT).exists()
        if exists and not resume:
            raise errors.TrainingError(errors.USAGE, out, "holds a training already: go on with --resume, or name another.")
        if resume and not exists:
            raise errors.TrainingError(errors.FILE, self.out / CHECKPOINT, "is missing: nothing to resume.")
        self.trainer = Trainer(config, lambda: split_shards(config.data)[0])
        if resume:
            self.trainer.resume(self.out / CHECKPOINT)
        self.journal = Journal(self.out / "log.jsonl", self.trainer.step)
        self.progress = Progress("train", config.train.steps)
        self.started = self.saved = self.evaluated = time.monotonic()
        self.stop_after_s = stop_after_s
        self.interrupted = False
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self.interrupt)
        self.sums = {}
        self.logged = (self.trainer.step, self.trainer.seconds)

    def interrupt(self, *_):
        """The step that runs is finished, and a checkpoint written."""
        self.interrupted = True

    def after_step(self, terms):
        trainer, train = self.trainer, self.config.train
        for name, value in terms.items():
            self.sums[name] = self.sums.get(name, 0.0) + value
        if trainer.step % train.log_every == 0:
            self.log()
        now = time.monotonic()
        if now - self.evaluated > train.evaluate_every_s:
            self.evaluate()
            self.evaluated = time.monotonic()
        if now - self.saved > train.checkpoint_every_s:
            self.save()
            self.saved = time.monotonic()
        return self.interrupted or (self.stop_after_s is not None and now - self.started > self.stop_after_s)

    def log(self):
        steps = self.trainer.step - self.logged[0]
        seconds = self.trainer.seconds - self.logged[1]
        rate = steps * self.config.train.batch / max(seconds, 1e-9)
        entry = {"step": self.trainer.step, "seconds": round(self.trainer.seconds, 1), "samples_per_s": round(rate, 2),
                 "learning_rate": self.trainer.optimiser.param_groups[0]["lr"]}
        entry.update({name: value / steps for name, value in self.sums.items()})
        self.journal.add(entry)
        self.progress.show(self.trainer.step, f"loss {entry['loss']:.3f}  {rate:.1f} samples/s")
        self.sums, self.logged = {}, (self.trainer.step, self.trainer.seconds)

    def evaluate(self):
        rows = []
        entry = {"step": self.trainer.step, "evaluation": rows}
        if self.validation:
            rows += evaluate(self.trainer.average.network, self.validation, self.config, classical=False)[0]
        if self.config.recording.folder:
            means, _ = evaluate_recording(self.trainer.average.network, self.config)
            entry.update({f"recording_{name}": value for name, value in means.get("network", {}).items()})
        for row in rows:
            if row["family"] == "overall":
                entry.update({f"{name}_{row['set']}": row[name] for name in ("d1", "abs_rel", "rmse_log", "idx_mae")})
        self.journal.add(entry)
        self.draw()

    def save(self):
        self.trainer.save(self.out)
        self.draw()

    def draw(self):
        draw_curves(self.journal.series(), self.out / "curves.png", _CURVES)


def main():
    parser = argparse.ArgumentParser(prog="egofocus_training.train", description=__doc__)
    parser.add_argument("--config", required=True)
    parser.add_argument("--out", required=True, help="folder of checkpoint.pt, weights.pt, log.jsonl, curves.png")
    parser.add_argument("--resume", action="store_true", help="go on from the folder's checkpoint")
    parser.add_argument("--stop-after-s", type=float, help="stop with a checkpoint after so many seconds")
    arguments = parser.parse_args()
    keep_freed_memory()
    config = load_config(arguments.config)
    if config.train.threads > 0:
        torch.set_num_threads(config.train.threads)
    if config.train.device == "cuda" and not torch.cuda.is_available():
        raise errors.TrainingError(errors.CONFIGURATION, arguments.config, "[train] device is cuda, and this machine or this "
                                   "build of PyTorch has none.")
    run = Run(config, arguments.out, arguments.resume, arguments.stop_after_s)
    run.trainer.run(config.train.steps, run.after_step)
    if run.interrupted:
        run.save()
        run.progress.end()
        print(f"interrupted at step {run.trainer.step}; --resume goes on", file=sys.stderr)
        return 130
    run.evaluate()
    run.save()
    run.progress.end()
    return 0


if __name__ == "__main__":
    errors.run(main)
