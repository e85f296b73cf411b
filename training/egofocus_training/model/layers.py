"""What the stages are built of."""
import torch
from torch import nn
from torch.nn import functional

from .bytes import Bytes, ConvBnRelu


class Residual(nn.Module):
    """relu(x + conv(conv(x)))"""

    def __init__(self, channels, dilation=1):
        super().__init__()
        self.first = ConvBnRelu(channels, channels, dilation=dilation)
        self.second = ConvBnRelu(channels, channels, dilation=dilation, relu=False)
        self.sum = Bytes()

    def forward(self, x):
        return self.sum(functional.relu(x + self.second(self.first(x)), inplace=True))


class Bottleneck(nn.Module):
    """relu(x + conv1x1(conv3x3(conv1x1(x)))), a quarter of the channels inside"""

    def __init__(self, channels):
        super().__init__()
        inner = max(channels // 4, 8)
        self.body = nn.Sequential(ConvBnRelu(channels, inner, 1), ConvBnRelu(inner, inner, 3),
                                  ConvBnRelu(inner, channels, 1, relu=False))

    def forward(self, x):
        return functional.relu(x + self.body(x), inplace=True)


class UpSum(nn.Module):
    """relu(x + up(y)): both in the scale of x, rounded once after the sum, halves upwards."""

    def __init__(self):
        super().__init__()
        self.small = Bytes(low=-128)
        self.sum = Bytes(half_up=True)

    def forward(self, x, y):
        return self.sum(functional.relu(x + twice_as_large(self.small(y), x), inplace=True))


def twice_as_large(x, like):
    """Bilinear, weights 9 3 3 1 of 16 between the four nearest centres; cut to the size of `like`."""
    large = functional.interpolate(x, scale_factor=2, mode="bilinear", align_corners=False)
    return large[..., :like.shape[-2], :like.shape[-1]]


def per_hypothesis(x):
    """[B, D, c, h, w] -> [B * D, c, h, w]: one filter for all hypotheses."""
    return x.reshape(-1, *x.shape[2:])


def neighbours(x):
    """Along the hypotheses: Gd = (x[k+1] - x[k-1]) / 2 and Gdd = x[k+1] - 2 x[k] + x[k-1]; both ends repeat. x: [B, D, ...]."""
    after = torch.cat([x[:, 1:], x[:, -1:]], 1)
    before = torch.cat([x[:, :1], x[:, :-1]], 1)
    return (after - before) / 2, after - 2 * x + before
