"""Training windows in a seeded order: what step n trains on depends on the seed and the shards alone."""
import functools
import signal

import numpy as np
import torch

from . import library
from .augment import augment
from .errors import BAD_FILE, TrainingError
from .machine import keep_freed_memory
from .samples import FAMILIES, Shard
from .windows import network_inputs, sample_facts, training_targets

_WORLDS_TOGETHER = 256
_ATTEMPTS = 20  # windows without parallax have no stack: another one takes their place


def spread(count, wanted):
    """Up to `wanted` of `count` indices, evenly spread."""
    return np.unique(np.linspace(0, count - 1, min(count, wanted)).astype(int))


class WindowDataset(torch.utils.data.Dataset):
    """Item (epoch, position): the window at this position of the epoch's order, augmented."""

    def __init__(self, paths, config):
        self.config = config
        self.shards = [Shard(path) for path in paths]
        self.at = [(s, i) for s, shard in enumerate(self.shards) for i in range(len(shard))]
        if config.data.families:
            wanted = {FAMILIES.index(name) for name in config.data.families}
            self.at = [(s, i) for s, i in self.at if self.shards[s].family(i) in wanted]
        if config.data.limit > 0:
            self.at = [self.at[i] for i in spread(len(self.at), config.data.limit)]
        self.world = np.array([self.shards[s].world(i) for s, i in self.at], np.uint64)
        if not self.at:
            raise TrainingError(BAD_FILE, self.shards[0].path, "holds no samples of the wanted families.")

    def __len__(self):
        return len(self.at)

    @functools.lru_cache(maxsize=2)
    def order(self, epoch):
        """A permutation that keeps the windows of a world near each other, among those of many others: one table of
        rays serves them all."""
        random = np.random.default_rng([self.config.train.seed, 1, epoch])
        worlds, of = np.unique(self.world, return_inverse=True)
        rank = random.permutation(len(worlds))[of]
        return np.lexsort((random.random(len(of)), rank // _WORLDS_TOGETHER))

    def __getitem__(self, key):
        """An error is an item, too: a worker's exception would lose its exit code on the way."""
        try:
            return self.window(*key)
        except TrainingError as error:
            return error

    def window(self, epoch, position):
        random = np.random.default_rng([self.config.train.seed, 2, epoch, position])
        where = int(self.order(epoch)[position])
        for _ in range(_ATTEMPTS):
            shard, index = self.at[where]
            of_world = np.random.default_rng([self.config.train.seed, 3, epoch, int(self.world[where])])
            sample, crop, span = augment(self.shards[shard][index], self.config.augment, random, of_world)
            try:
                facts = sample_facts(sample, self.config, (), crop, span)
            except library.stack.StackError as error:
                raise TrainingError(BAD_FILE, f"{self.shards[shard].path}, sample {index}", str(error)) from None
            if facts["has_stack"]:
                item = network_inputs(facts, self.config.network.order)
                item.update(training_targets(sample, facts, crop, self.config.loss, self.config.input.hypotheses))
                return item
            where = int(random.integers(len(self.at)))
        raise TrainingError(BAD_FILE, self.shards[shard].path, f"{_ATTEMPTS} windows in a row have no parallax. "
                            "Is the ladder's min_parallax_px too large for these samples?")


def collate(items):
    """Stacks numpy arrays into tensors; the histogram becomes float. The first error stands for the batch."""
    for item in items:
        if isinstance(item, TrainingError):
            return item
    out = {}
    for name in items[0]:
        stacked = torch.from_numpy(np.stack([item[name] for item in items]))
        out[name] = stacked.float() if name == "label" else stacked
    return out


def _prepare_worker(_):
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the training process decides when to stop
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    keep_freed_memory()
    torch.set_num_threads(1)
    train = torch.utils.data.get_worker_info().dataset.config.train
    library.stack.keep_rays(train.ray_cache_mb << 20)


def epoch_loader(dataset, epoch, first_batch):
    """Batches of one epoch from `first_batch` on; what does not fill a batch is left out."""
    train = dataset.config.train
    batches = [[(epoch, b * train.batch + i) for i in range(train.batch)]
               for b in range(first_batch, len(dataset) // train.batch)]
    workers = {"num_workers": train.workers, "worker_init_fn": _prepare_worker, "prefetch_factor": 4} if train.workers else {}
    return torch.utils.data.DataLoader(dataset, batch_sampler=batches, collate_fn=collate, **workers)
