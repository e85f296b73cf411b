"""EMA of the weights: e <- d e + (1 - d) w, with d = min(decay, (1 + n) / (10 + n)) at update n, so that it starts fast."""
import copy

import torch


class WeightAverage:
    def __init__(self, network, decay):
        self.decay = decay
        self.network = copy.deepcopy(network).eval()
        self.network.requires_grad_(False)

    @torch.no_grad()
    def update(self, network, step):
        decay = min(self.decay, (1 + step) / (10 + step))
        for mine, theirs in zip(self.network.state_dict().values(), network.state_dict().values()):
            if mine.dtype.is_floating_point:
                mine.lerp_(theirs, 1 - decay)
            else:
                mine.copy_(theirs)
