"""The baseline: a recurrent U-Net on voxel grids, in the manner of E2Depth. What the focus network sees by warping events along
each hypothesis, this one has to find by itself; the measured motion stands beside each slice as constant planes, so that it can
know the scale.

    x_t = [stem V_t, motion of slice t, x/z, y/z]                       at 1/2
    s_4 = gru(conv x),  s_8 = gru(conv s_4),  s_16 = gru(conv s_8)      over the slices; their last states go on
    b_8 = block(relu(s_8 + up(conv block(s_16)))),  b_4 = block(relu(s_4 + up(conv b_8)))
    S = head(b_4);  i_4 as in regression.py;  i = clamp(up(i_4) + r([up(i_4) / D, up(relu(conv b_4)), stem V_T]), 0, K - 1)
"""
import torch
from torch import nn

from ..voxels import MOTIONS, STEP
from .bytes import ConvBnRelu
from .layers import Residual, UpSum, twice_as_large
from .network import Prediction
from .regression import confidence, distribution, expected_index, median_index

_GUIDE = 4


class ConvGru(nn.Module):
    """h' = (1 - z) n + z h,  z, r = sigmoid(A x + B h),  n = tanh(A x + r B h);  A: 1x1, B: 3x3, h = 0 before the first.
    x [T, B, w, h, w'] -> the states of all T, same shape"""

    def __init__(self, width):
        super().__init__()
        self.of_input = nn.Conv2d(width, 3 * width, 1)
        self.of_state = nn.Conv2d(width, 3 * width, 3, padding=1, bias=False)

    def forward(self, x):
        given = self.of_input(x.flatten(0, 1)).unflatten(0, x.shape[:2])
        states = []
        for step in given:
            keep, reset, new = step.chunk(3, 1)
            if states:
                old_keep, old_reset, old_new = self.of_state(states[-1]).chunk(3, 1)
                keep = torch.sigmoid(keep + old_keep)
                new = torch.tanh(new + torch.sigmoid(reset + old_reset) * old_new)
                states.append(torch.lerp(new, states[-1], keep))
            else:
                states.append((1 - torch.sigmoid(keep)) * torch.tanh(new))
        return torch.stack(states)


class RecurrentLevel(nn.Module):
    """States at half the scale: x [T, B, inputs, h, w] -> [T, B, width, ceil(h / 2), ceil(w / 2)]"""

    def __init__(self, inputs, width):
        super().__init__()
        self.down = ConvBnRelu(inputs, width, stride=2)
        self.gru = ConvGru(width)

    def forward(self, x):
        return self.gru(self.down(x.flatten(0, 1)).unflatten(0, x.shape[:2]))


class RecurrentNetwork(nn.Module):
    """Inputs, a dict of tensors: slices int8 [B, T, bins, h, w], motion float [B, T, 8], rays float [B, 2, h/2, w/2] (voxels.py),
    used int64 [B]: hypotheses of the ladder."""

    def __init__(self, input_config, config, median):
        super().__init__()
        self.hypotheses = depth = input_config.hypotheses
        self.median = median
        w4, w8, w16 = config.widths
        self.stem = ConvBnRelu(config.bins, config.stem, stride=2)
        self.at_4 = RecurrentLevel(config.stem + MOTIONS + 2, w4)
        self.at_8 = RecurrentLevel(w4, w8)
        self.at_16 = RecurrentLevel(w8, w16)
        self.block_16 = Residual(w16)
        self.narrow_16 = ConvBnRelu(w16, w8, 1, relu=False)
        self.join_8 = UpSum()
        self.block_8 = Residual(w8)
        self.narrow_8 = ConvBnRelu(w8, w4, 1, relu=False)
        self.join_4 = UpSum()
        self.block_4 = Residual(w4)
        self.head = nn.Conv2d(w4, depth, 1)
        self.coarse_head = nn.Conv2d(w8, depth, 1)  # training alone
        self.guide = ConvBnRelu(w4, _GUIDE, 1)
        width = config.refine_width
        self.refine = nn.Sequential(ConvBnRelu(1 + _GUIDE + config.stem, width),
                                    *(ConvBnRelu(width, width, dilation=d) for d in config.refine_dilations))
        self.change = nn.Conv2d(width, 1, 3, padding=1)
        nn.init.zeros_(self.change.weight)
        nn.init.zeros_(self.change.bias)

    def forward(self, inputs):
        slices = inputs["slices"].transpose(0, 1)
        motion, rays = inputs["motion"].transpose(0, 1), inputs["rays"]
        stem = self.stem(slices.flatten(0, 1).float() * STEP).unflatten(0, slices.shape[:2])
        planes = motion[..., None, None].expand(*motion.shape, *stem.shape[-2:])
        states_4 = self.at_4(torch.cat([stem, planes, rays.expand(len(slices), *rays.shape)], 2))
        states_8 = self.at_8(states_4)
        s16 = self.at_16(states_8)[-1]
        b8 = self.block_8(self.join_8(states_8[-1], self.narrow_16(self.block_16(s16))))
        b4 = self.block_4(self.join_4(states_4[-1], self.narrow_8(b8)))
        scores = self.head(b4)
        p = distribution(scores, inputs["used"])
        index_4 = median_index(p, inputs["used"]) if self.median else expected_index(p)
        index = self.refined(index_4, self.guide(b4), stem[-1], inputs["used"])
        coarse = self.coarse_head(b8) if self.training else None
        with torch.no_grad():
            moved_px = step_px(motion.mean(0), rays[..., ::2, ::2])
            trust = confidence(p, index_4, moved_px)
        return Prediction(scores, coarse, index_4, index, trust, moved_px)

    def refined(self, index_4, guide, stem, used):
        start = twice_as_large(index_4[:, None], stem)
        change = self.change(self.refine(torch.cat([start / self.hypotheses, twice_as_large(guide, stem), stem], 1)))
        return torch.minimum((start + change.float())[:, 0].clamp(min=0), (used - 1)[:, None, None].to(start.dtype))


def step_px(motion, rays):
    """How far one hypothesis moves a cell, px [B, h, w]: motion [B, 8], rays [B, 2, h, w]."""
    across, forward = motion[:, :2, None, None], motion[:, 2:3, None, None]
    return (across - forward * rays).norm(dim=1)
