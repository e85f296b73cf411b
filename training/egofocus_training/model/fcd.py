"""FCD, focus cost discrimination: how sharp is each hypothesis? One filter for all of them.

Focus first: gradient energies E_k under supports r were taken from the full-resolution image by the library
(focus_input.py); here  C_k = conv(relu(conv(z_k)))  of all maps of hypothesis k, 3x3. Without hidden channels one
convolution is left, without cost channels none: C = z.

Published order, of features F [D, h, w], one channel per hypothesis:
    G_X = maps {Gx, Gy, Gxx, Gyy, Gxy, Gxx * Gyy} of F_k,   R = sum_X w_X f_X(G_X),   C_k = sqrt(box_r R^2)
with f_X a 3x3 filter and ReLU shared by all hypotheses; several R of different w make the cost channels.
"""
import torch
from torch import nn
from torch.nn import functional

from .bytes import ConvBnRelu
from .layers import per_hypothesis

_X = [[0, 0, 0], [-0.5, 0, 0.5], [0, 0, 0]]
_Y = [[0, -0.5, 0], [0, 0, 0], [0, 0.5, 0]]
_XX = [[0, 0, 0], [1, -2, 1], [0, 0, 0]]
_YY = [[0, 1, 0], [0, -2, 0], [0, 1, 0]]
_XY = [[0.25, 0, -0.25], [0, 0, 0], [-0.25, 0, 0.25]]


class FocusCost(nn.Module):
    """z [B, D, maps, h, w] -> C [B, D, channels, h, w]; `channels` may differ from the wanted number: see above."""

    def __init__(self, maps, hidden, channels):
        super().__init__()
        layers = []
        if channels > 0 and hidden > 0:
            layers = [ConvBnRelu(maps, hidden), ConvBnRelu(hidden, channels)]
        elif channels > 0:
            layers = [ConvBnRelu(maps, channels)]
        self.filter = nn.Sequential(*layers)
        self.channels = channels if channels > 0 else maps

    def forward(self, z):
        batch, depth = z.shape[:2]
        cost = self.filter(per_hypothesis(z))
        return cost.reshape(batch, depth, *cost.shape[1:])


def gradient_maps(features):
    """[N, 1, h, w] -> [N, 6, h, w]: Gx, Gy, Gxx, Gyy, Gxy, Gxx * Gyy, zero outside."""
    weight = torch.tensor([_X, _Y, _XX, _YY, _XY], dtype=features.dtype, device=features.device)[:, None]
    maps = functional.conv2d(features, weight, padding=1)
    return torch.cat([maps, maps[:, 2:3] * maps[:, 3:4]], 1)


class FeatureFocusCost(nn.Module):
    """F [B, D, h, w] -> C [B, D, cost channels, h, w]"""

    def __init__(self, channels, support=3):
        super().__init__()
        self.discriminate = ConvBnRelu(6, 6, groups=6)
        self.combine = nn.Conv2d(6, channels, 1, bias=False)
        self.support = support
        self.channels = channels

    def forward(self, features):
        batch, depth, h, w = features.shape
        maps = self.discriminate(gradient_maps(features.reshape(-1, 1, h, w)))
        response = self.combine(maps)
        energy = functional.avg_pool2d(response * response, self.support, 1, self.support // 2) * self.support ** 2
        return torch.sqrt(energy + 1e-4).reshape(batch, depth, -1, h, w)
