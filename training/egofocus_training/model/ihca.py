"""IHCA, inter-hypotheses cost aggregation: a peak is a peak only beside its neighbours.

    C' = relu(C + conv([C, Gd, Gdd]))        Gd, Gdd: first and second difference along the hypotheses

Fixed differences and a filter shared by all hypotheses are together a 3x3x3 convolution, run as a 2-D one.
"""
from torch import nn
from torch.nn import functional

import torch

from .bytes import Bytes, ConvBnRelu
from .layers import neighbours, per_hypothesis


class InterHypothesisBlock(nn.Module):
    """C [B, D, c, h, w] -> C' of the same shape"""

    def __init__(self, channels):
        super().__init__()
        self.filter = ConvBnRelu(3 * channels, channels, relu=False)
        self.sum = Bytes()

    def forward(self, cost):
        stacked = torch.cat([cost, *neighbours(cost)], 2)
        change = self.filter(per_hypothesis(stacked)).reshape(cost.shape)
        return self.sum(functional.relu(cost + change))
