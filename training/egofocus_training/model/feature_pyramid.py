"""Published order: features before focus. IWE stack -> stem -> ResNet at 1/4, 1/8, 1/16 -> FPN -> D channels at 1/4.

    P_4 = lateral(R_4) + up(P_8),  P_8 = lateral(R_8) + up(P_16),  P_16 = lateral(R_16);  F = conv(P_4)
"""
from torch import nn

from .bytes import ConvBnRelu
from .layers import Bottleneck, twice_as_large


class FeaturePyramid(nn.Module):
    """IWE stack [B, D, H, W] -> F [B, D, H / 4, W / 4]"""

    def __init__(self, hypotheses, stem, widths, blocks):
        super().__init__()
        self.stem = nn.Sequential(ConvBnRelu(hypotheses, stem, stride=2), ConvBnRelu(stem, stem))
        self.stages = nn.ModuleList()
        inputs = stem
        for width, count in zip(widths, blocks):
            self.stages.append(nn.Sequential(ConvBnRelu(inputs, width, stride=2),
                                             *(Bottleneck(width) for _ in range(count))))
            inputs = width
        self.laterals = nn.ModuleList(nn.Conv2d(width, hypotheses, 1) for width in widths)
        self.smooth = nn.Conv2d(hypotheses, hypotheses, 3, padding=1)

    def forward(self, stack):
        x = self.stem(stack)
        levels = []
        for stage in self.stages:
            x = stage(x)
            levels.append(x)
        pyramid = self.laterals[-1](levels[-1])
        for lateral, level in zip(reversed(self.laterals[:-1]), reversed(levels[:-1])):
            pyramid = lateral(level) + twice_as_large(pyramid, level)
        return self.smooth(pyramid)
