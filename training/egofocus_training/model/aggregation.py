"""Cross-scale aggregation: hypotheses as channels, mixed over ever wider surroundings and brought back.

    a_4 = blocks(mix [C, context]),  a_8 = blocks(down a_4),  a_16 = blocks(down a_8)
    b_8 = blocks(a_8 + up(conv a_16)),  b_4 = blocks(a_4 + up(conv b_8))
    S_k = head(b_4)_k + c_k         c_k: one number per hypothesis of C, by a filter that all hypotheses share
"""
from torch import nn

import torch

from .layers import ConvBnRelu, Residual, per_hypothesis, twice_as_large


class CrossScaleAggregation(nn.Module):
    """(C [B, D, c, h, w], context [B, n, h, w]) -> (scores [B, D, h, w], scores at half the scale, features b_4)"""

    def __init__(self, hypotheses, cost_channels, context, widths, blocks, up_blocks):
        super().__init__()
        w4, w8, w16 = widths
        self.mix = ConvBnRelu(hypotheses * cost_channels + context, w4, 1)
        self.at_4 = nn.Sequential(*(Residual(w4) for _ in range(blocks[0])))
        self.at_8 = nn.Sequential(ConvBnRelu(w4, w8, stride=2), *(Residual(w8) for _ in range(blocks[1])))
        self.at_16 = nn.Sequential(ConvBnRelu(w8, w16, stride=2), *(Residual(w16) for _ in range(blocks[2])))
        self.narrow_16 = ConvBnRelu(w16, w8, 1, relu=False)
        self.up_8 = nn.Sequential(nn.ReLU(inplace=True), *(Residual(w8) for _ in range(up_blocks[1])))
        self.narrow_8 = ConvBnRelu(w8, w4, 1, relu=False)
        self.up_4 = nn.Sequential(nn.ReLU(inplace=True), *(Residual(w4) for _ in range(up_blocks[0])))
        self.head = nn.Conv2d(w4, hypotheses, 1)
        self.coarse_head = nn.Conv2d(w8, hypotheses, 1)  # training alone
        self.own_score = nn.Conv2d(cost_channels, 1, 1, bias=False)
        # At first the focus cost alone decides; what surroundings say is learnt on top of it.
        nn.init.zeros_(self.head.weight)
        nn.init.zeros_(self.head.bias)
        nn.init.constant_(self.own_score.weight, 1.0 / cost_channels)

    def forward(self, cost, context):
        batch, depth, _, h, w = cost.shape
        a4 = self.at_4(self.mix(torch.cat([cost.reshape(batch, -1, h, w), context], 1)))
        a8 = self.at_8(a4)
        a16 = self.at_16(a8)
        b8 = self.up_8(a8 + twice_as_large(self.narrow_16(a16), a8))
        b4 = self.up_4(a4 + twice_as_large(self.narrow_8(b8), a4))
        own = self.own_score(per_hypothesis(cost)).reshape(batch, depth, h, w)
        coarse = self.coarse_head(b8) if self.training else None
        return self.head(b4) + own, coarse, b4
