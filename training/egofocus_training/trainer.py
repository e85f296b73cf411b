"""The training loop. A run that is stopped anywhere goes on from its last checkpoint as if it had never been."""
import math
import pathlib
import time

import torch

from . import checkpoint
from .average import WeightAverage
from .dataset import WindowDataset, epoch_loader
from .errors import CONFIGURATION, DIVERGED, TrainingError
from .losses import loss_terms
from .model.build import network_of
from .quantisation import calibrate, is_quantised, set_rounding

CHECKPOINT = "checkpoint.pt"
WEIGHTS = "weights.pt"  # the average alone: what is evaluated and shipped


def learning_rate(step, train):
    """Linear from 0, then a half cosine to 0."""
    if step < train.warmup_steps:
        return train.learning_rate * (step + 1) / train.warmup_steps
    share = (step - train.warmup_steps) / max(train.steps - train.warmup_steps, 1)
    return train.learning_rate * 0.5 * (1 + math.cos(math.pi * min(share, 1)))


def parameter_groups(network, weight_decay):
    """Weights decay; biases and batch norm do not."""
    decayed = [p for p in network.parameters() if p.ndim > 1]
    others = [p for p in network.parameters() if p.ndim <= 1]
    return [{"params": decayed, "weight_decay": weight_decay}, {"params": others, "weight_decay": 0.0}]


class Trainer:
    """Network, optimiser, average and the place in the data. `find_paths()` lists the shards; asked again each epoch, so
    that shards which were made meanwhile are used."""

    def __init__(self, config, find_paths):
        self.config, self.find_paths = config, find_paths
        torch.manual_seed(config.train.seed)
        self.device = torch.device(config.train.device)
        self.network = network_of(config).to(self.device, memory_format=torch.channels_last)
        if config.train.start:
            checkpoint.start_from(config.train.start, self.network)
        self.average = WeightAverage(self.network, config.train.ema)
        self.optimiser = torch.optim.AdamW(parameter_groups(self.network, config.train.weight_decay),
                                           lr=config.train.learning_rate)
        self.step = self.epoch = self.batch = 0
        self.seconds = 0.0  # of training, over all runs
        self.shards = [str(path) for path in find_paths()]
        last_steps = config.quantise.last_steps
        self.quantised_from = config.train.steps - last_steps if last_steps else math.inf  # step

    def state(self):
        return {"network_facts": self.config.network_facts(), "network": self.network.state_dict(),
                "average": self.average.network.state_dict(), "optimiser": self.optimiser.state_dict(), "step": self.step,
                "quantised": is_quantised(self.network), "epoch": self.epoch, "batch": self.batch, "seconds": self.seconds, "shards": self.shards}

    def save(self, folder):
        checkpoint.write(pathlib.Path(folder) / CHECKPOINT, self.state())
        checkpoint.write(pathlib.Path(folder) / WEIGHTS,
                         {"network_facts": self.config.network_facts(), "step": self.step,
                          "quantised": is_quantised(self.average.network),
                          "network": self.average.network.state_dict()})

    def resume(self, path):
        state = checkpoint.read(path, self.device)
        checkpoint.require_same_network(path, state, self.config)
        checkpoint.load_weights(self.network, state["network"], path)
        checkpoint.load_weights(self.average.network, state["average"], path)
        self.optimiser.load_state_dict(state["optimiser"])
        if state["quantised"]:
            set_rounding(self.network, True)
            set_rounding(self.average.network, True)
        self.step, self.epoch, self.batch = state["step"], state["epoch"], state["batch"]
        self.seconds, self.shards = state["seconds"], state["shards"]

    def train_step(self, batch):
        """One update; the loss's terms as floats. TrainingError (DIVERGED) before anything is spoilt."""
        train = self.config.train
        batch = {name: tensor.to(self.device) for name, tensor in batch.items()}
        for group in self.optimiser.param_groups:
            group["lr"] = learning_rate(self.step, train)
        self.optimiser.zero_grad(set_to_none=True)
        with torch.autocast(self.device.type, torch.bfloat16, enabled=train.bf16):
            prediction = self.network(batch)
        terms = loss_terms(prediction, batch, self.config.loss)
        loss = sum(terms.values())
        loss.backward()
        norm = torch.nn.utils.clip_grad_norm_(self.network.parameters(), train.clip_norm)
        if not (torch.isfinite(loss) and torch.isfinite(norm)):
            raise TrainingError(DIVERGED, f"step {self.step} (epoch {self.epoch}, batch {self.batch})",
                                "loss or gradient is not a number any more; the last checkpoint is untouched. "
                                "Go on from it with a smaller learning_rate.")
        self.optimiser.step()
        self.average.update(self.network, self.step)
        self.step += 1
        self.batch += 1
        return {name: float(term) for name, term in terms.items()} | {"loss": float(loss)}

    def quantise(self, dataset):
        """From here on the average is trained, with the integer model's rounding in it."""
        batches = []
        for inputs in epoch_loader(dataset, 0, 0):
            if isinstance(inputs, TrainingError):
                raise inputs
            batches.append({name: tensor.to(self.device) for name, tensor in inputs.items()})
            if len(batches) == self.config.quantise.calibration_batches:
                break
        calibrate(self.average.network, batches)
        self.network.load_state_dict(self.average.network.state_dict())
        set_rounding(self.network, True)
        set_rounding(self.average.network, True)

    def run(self, until, after_step):
        """Trains until this step; after_step(terms) after each, which may stop by returning True."""
        self.network.train()
        stopped = False
        while self.step < until and not stopped:
            dataset = WindowDataset(self.shards, self.config)
            batches = len(dataset) // self.config.train.batch
            if batches == 0:
                raise TrainingError(CONFIGURATION, "[train] batch", f"{len(dataset)} samples do not fill one batch.")
            if not is_quantised(self.network) and self.quantised_from <= self.step:
                self.quantise(dataset)
            last = time.monotonic()
            for batch in epoch_loader(dataset, self.epoch, self.batch):
                if isinstance(batch, TrainingError):
                    raise batch
                terms = self.train_step(batch)
                now = time.monotonic()
                self.seconds += now - last
                last = now
                stopped = after_step(terms)
                if stopped or self.step >= until or self.step == self.quantised_from:
                    break
            if self.batch >= batches:
                self.epoch, self.batch = self.epoch + 1, 0
                self.shards = [str(path) for path in self.find_paths()]
