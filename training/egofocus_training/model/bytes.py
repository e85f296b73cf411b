"""Integers in the network: where the integer model keeps a tensor as bytes, and convolutions with the weights it will have.

Until quantise() (quantisation.py) gave it a scale, all this lets numbers pass as they are. From then on
    Bytes:  x -> scale * clamp(round(x / scale), low, high)
    Conv, ConvBnRelu: batch norm folded into w and b;  w_o -> s_o * clamp(round(w_o / s_o), -127, 127), s_o = max |w_o| / 127
with the gradient of the clamp alone (straight through the rounding). docs/integer_model.md has the integers themselves.
"""
import torch
from torch import nn
from torch.nn import functional

SHARE_INSIDE = 0.9999  # of a tensor's values that its scale reaches
_TIE = 1 / 512  # what rounds halves upwards has whole 128ths or sixteenths: floats miss a half by less than this


class Bytes(nn.Module):
    """A tensor of the integer model. low..high: 0..127 after a ReLU, -128..127 for what is only added, int16 for scores."""

    def __init__(self, low=0, high=127, half_up=False, scale=0.0):
        super().__init__()
        self.low, self.high, self.half_up = low, high, half_up
        self.fixed = scale > 0  # by definition, not by what was seen
        self.register_buffer("scale", torch.tensor(float(scale)))
        self.active = False
        self.seen = None  # while observed: the reach of each batch

    def forward(self, x):
        if self.seen is not None:
            values = x.detach().abs().flatten().float()
            values = values[::max(values.numel() // 1_000_000, 1)]
            self.seen.append(torch.quantile(values, SHARE_INSIDE).item())
        if not self.active:
            return x
        inside = (x.float() / self.scale).clamp(self.low, self.high)
        whole = torch.floor(inside + 0.5 + _TIE) if self.half_up else torch.round(inside)
        return (inside + (whole - inside).detach()) * self.scale


def rounded_weights(weight, columns=None):
    """(weights that int8 can hold, scale of each output channel). columns: what each input channel is multiplied by first,
    because its bytes have another scale than the first one's."""
    shape = (-1, 1, 1, 1)
    if columns is not None:
        columns = columns.reshape(1, -1, 1, 1)
        weight = weight * columns
    scale = (weight.detach().abs().amax((1, 2, 3)) / 127).clamp(min=1e-12)
    inside = (weight / scale.reshape(shape)).clamp(-127, 127)
    rounded = (inside + (torch.round(inside) - inside).detach()) * scale.reshape(shape)
    return (rounded / columns if columns is not None else rounded), scale


class Conv(nn.Conv2d):
    """A convolution without batch norm; int8 weights once active."""

    active = False

    def folded(self):
        return self.weight, self.bias

    def forward(self, x):
        if not self.active:
            return super().forward(x)
        weight, _ = rounded_weights(self.weight)
        return self._conv_forward(x, weight, self.bias)


class ConvBnRelu(nn.Sequential):
    """relu(bn(conv(x))), and where it goes on as bytes: one integer convolution with a clamp once folded. Padding keeps the
    size (stride 1). mixed: the input's channels have scales of several kinds."""

    active = False

    def __init__(self, inputs, outputs, kernel=3, stride=1, dilation=1, groups=1, relu=True, mixed=False):
        layers = [nn.Conv2d(inputs, outputs, kernel, stride, dilation * (kernel // 2), dilation, groups, bias=False),
                  nn.BatchNorm2d(outputs)]
        super().__init__(*layers, *([nn.ReLU(inplace=True), Bytes()] if relu else []))
        if mixed:
            self.register_buffer("columns", torch.ones(inputs))
        else:
            self.columns = None

    def folded(self):
        """Weights and bias with batch norm in them, as it stands outside training."""
        conv, norm = self[0], self[1]
        factor = norm.weight / torch.sqrt(norm.running_var + norm.eps)
        return conv.weight * factor.reshape(-1, 1, 1, 1), norm.bias - norm.running_mean * factor

    def forward(self, x):
        if not self.active:
            return super().forward(x)
        conv = self[0]
        weight, bias = self.folded()
        weight, _ = rounded_weights(weight, self.columns)
        x = functional.conv2d(x, weight, bias, conv.stride, conv.padding, conv.dilation, conv.groups)
        for layer in list(self)[2:]:
            x = layer(x)
        return x
