"""Cross-scale aggregation: hypotheses as channels, mixed over ever wider surroundings and brought back.

    a_4 = blocks(mix [C, context]),  a_8 = blocks(down a_4),  a_16 = blocks(down a_8)
    b_8 = blocks(relu(a_8 + up(conv a_16))),  b_4 = blocks(relu(a_4 + up(conv b_8)))
    S_k = head(b_4)_k + c_k         c_k: one number per hypothesis of C, by a filter that all hypotheses share
"""
from torch import nn

import torch

from .bytes import Bytes, Conv, ConvBnRelu
from .layers import Residual, UpSum, per_hypothesis

SCORE = 1 / 32  # unit of the integer model's scores


class CrossScaleAggregation(nn.Module):
    """(C [B, D, c, h, w], context [B, n, h, w]) -> (scores [B, D, h, w], scores at half the scale, features b_4)"""

    def __init__(self, hypotheses, cost_channels, context, widths, blocks, up_blocks):
        super().__init__()
        w4, w8, w16 = widths
        self.mix = ConvBnRelu(hypotheses * cost_channels + context, w4, 1, mixed=True)
        self.at_4 = nn.Sequential(*(Residual(w4) for _ in range(blocks[0])))
        self.at_8 = nn.Sequential(ConvBnRelu(w4, w8, stride=2), *(Residual(w8) for _ in range(blocks[1])))
        self.at_16 = nn.Sequential(ConvBnRelu(w8, w16, stride=2), *(Residual(w16) for _ in range(blocks[2])))
        self.narrow_16 = ConvBnRelu(w16, w8, 1, relu=False)
        self.join_8 = UpSum()
        self.up_8 = nn.Sequential(*(Residual(w8) for _ in range(up_blocks[1])))
        self.narrow_8 = ConvBnRelu(w8, w4, 1, relu=False)
        self.join_4 = UpSum()
        self.up_4 = nn.Sequential(*(Residual(w4) for _ in range(up_blocks[0])))
        self.head = Conv(w4, hypotheses, 1)
        self.head_score = Bytes(-32768, 32767, scale=SCORE)
        self.coarse_head = nn.Conv2d(w8, hypotheses, 1)  # training alone
        self.own = Conv(cost_channels, 1, 1, bias=False)
        self.own_score = Bytes(-32768, 32767, scale=SCORE)
        # At first the focus cost alone decides; what surroundings say is learnt on top of it.
        nn.init.zeros_(self.head.weight)
        nn.init.zeros_(self.head.bias)
        nn.init.constant_(self.own.weight, 1.0 / cost_channels)

    def forward(self, cost, context):
        batch, depth, _, h, w = cost.shape
        a4 = self.at_4(self.mix(torch.cat([cost.reshape(batch, -1, h, w), context], 1)))
        a8 = self.at_8(a4)
        a16 = self.at_16(a8)
        b8 = self.up_8(self.join_8(a8, self.narrow_16(a16)))
        b4 = self.up_4(self.join_4(a4, self.narrow_8(b8)))
        own = self.own_score(self.own(per_hypothesis(cost))).reshape(batch, depth, h, w)
        coarse = self.coarse_head(b8) if self.training else None
        return self.head_score(self.head(b4)) + own, coarse, b4

    def one_scale(self):
        """Lists of Bytes that are added to each other, and so share a scale."""
        def sums(blocks):
            return [block.sum for block in blocks if isinstance(block, Residual)]

        return [[self.mix[-1], *sums(self.at_4), self.join_4.small, self.join_4.sum, *sums(self.up_4)],
                [self.at_8[0][-1], *sums(self.at_8), self.join_8.small, self.join_8.sum, *sums(self.up_8)],
                [self.at_16[0][-1], *sums(self.at_16)]]
