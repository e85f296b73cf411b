"""Refinement at 1/2: borders, from the image of warped events that the prediction brings into focus.

    i_2 = up(i_4);  x = [i_2 / D, I_k for k = floor(i_2 + 1/2) - 1, 0, +1, guide];  i = near(clamp(i_2 + r(x), 0, K - 1))

r: 3x3 convolutions with dilations. I: counts over 2x2 px, compressed as min(n, 15) / 4. guide: up(relu(conv b_4)).
near: at borders the nearer surface, once trained.
"""
import torch
from torch import nn
from torch.nn import functional

from .bytes import Bytes, Conv, ConvBnRelu
from .layers import twice_as_large

_GUIDE = 4
COUNT = 1 / 4  # unit of the counts
STEP = 1 / 256  # unit of indices, in hypotheses
BORDER = 2.0  # hypotheses between two surfaces
_MOST_COUNTS = 15.0


def gather_focused(half, index):
    """Counts [B, D, h, w] u8 at floor(index + 1/2) - 1, 0, +1 (0 outside the ladder): [B, 3, h, w] in 0..15/4."""
    depth = half.shape[1]
    nearest = (index.detach() + 0.5).floor().long()
    planes = []
    for offset in (-1, 0, 1):
        k = nearest + offset
        plane = half.gather(1, k.clamp(0, depth - 1)[:, None])[:, 0].to(index.dtype)
        planes.append(plane.clamp(max=_MOST_COUNTS) * COUNT * ((k >= 0) & (k < depth)))
    return torch.stack(planes, 1)


def nearer_at_borders(index):
    """[B, h, w]: the largest of 3x3 where these span more than BORDER. The events of an occluding contour are those of the
    nearer surface; convolutions smear it over what is behind."""
    nearest = functional.max_pool2d(index[:, None], 3, 1, 1)[:, 0]
    farthest = -functional.max_pool2d(-index[:, None], 3, 1, 1)[:, 0]
    return torch.where(nearest - farthest > BORDER, nearest, index)


class Refinement(nn.Module):
    """(i_4 [B, h / 2, w / 2], counts [B, D, h, w], b_4, used [B]) -> i [B, h, w]"""

    def __init__(self, hypotheses, features, width, dilations):
        super().__init__()
        self.hypotheses = hypotheses
        self.start = Bytes(0, 65535, half_up=True, scale=STEP)
        self.place = Bytes(half_up=True, scale=0.5)
        self.guide = ConvBnRelu(features, _GUIDE, 1)
        self.large_guide = Bytes(half_up=True)
        self.first = ConvBnRelu(1 + 3 + _GUIDE, width, mixed=True)
        self.body = nn.Sequential(*(ConvBnRelu(width, width, dilation=d) for d in dilations))
        self.last = Conv(width, 1, 3, padding=1)
        self.change = Bytes(-32768, 32767, scale=STEP)
        nn.init.zeros_(self.last.weight)
        nn.init.zeros_(self.last.bias)

    def forward(self, index, half, features, used):
        start = self.start(twice_as_large(index[:, None], half))
        guide = self.large_guide(twice_as_large(self.guide(features), half))
        x = torch.cat([self.place(start) / self.hypotheses, gather_focused(half, start[:, 0]), guide], 1)
        refined = start + self.change(self.last(self.body(self.first(x))).float())
        index = torch.minimum(refined[:, 0].clamp(min=0), (used - 1)[:, None, None].to(refined.dtype))
        return index if self.training else nearer_at_borders(index)

    def one_scale(self):
        """Lists of Bytes that share a scale."""
        return [[self.guide[-1], self.large_guide]]
