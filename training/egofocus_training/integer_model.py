"""The network in integers, in plain numpy: the reference that every other implementation equals bit for bit.

docs/integer_model.md defines it. Tensors are bytes 0..127 (zero 0, the network's inputs 64), weights int8, sums int32; one
rounding rule (src/kernels/requant.hpp). Built from a quantised network; knows nothing of PyTorch afterwards.
"""
from dataclasses import dataclass

import numpy as np

from .errors import DIVERGED, TrainingError
from .model.aggregation import SCORE
from .model.bytes import rounded_weights
from .model.refinement import BORDER, STEP
from .units import CONTEXT, FOCUS, HIGH, ZERO

EXP = np.rint(65535 * np.exp(-np.arange(512) * SCORE)).astype(np.int64)  # a score d / 32 below the best
MOST_COUNTS = 15
BORDER_Q8 = round(BORDER / STEP)
ONE_PX = round(1 / STEP / CONTEXT)  # of an index times a context byte


@dataclass
class IntegerConv:
    """q_out = clamp(round(float(sum w (q_in - zero) + bias) * scale)); padding keeps the size at stride 1."""
    weight: np.ndarray  # int8 [outputs, inputs, n, n]
    bias: np.ndarray  # int32 [outputs]
    scale: np.ndarray  # float32 [outputs]
    stride: int = 1
    dilation: int = 1
    zero: int = 0

    def sums(self, x):
        """int64 [outputs, h, w] of x [inputs, h, w]."""
        outputs, inputs, n, _ = self.weight.shape
        x = x.astype(np.float64) - self.zero  # exact: sums stay far below 2^53
        border = self.dilation * (n // 2)
        x = np.pad(x, ((0, 0), (border, border), (border, border)))
        h = (x.shape[1] - self.dilation * (n - 1) - 1) // self.stride + 1
        w = (x.shape[2] - self.dilation * (n - 1) - 1) // self.stride + 1
        total = np.zeros((outputs, h * w))
        for i in range(n):
            for j in range(n):
                y0, x0 = i * self.dilation, j * self.dilation
                part = x[:, y0:y0 + (h - 1) * self.stride + 1:self.stride, x0:x0 + (w - 1) * self.stride + 1:self.stride]
                total += self.weight[:, :, i, j].astype(np.float64) @ part.reshape(inputs, -1)
        return total.reshape(outputs, h, w).astype(np.int64) + self.bias[:, None, None]

    def requantised(self, x):
        """int16 range, before any further clamp."""
        product = self.sums(x).astype(np.int32).astype(np.float32) * self.scale[:, None, None]
        return np.clip(np.rint(product), -32768, 32767).astype(np.int32)

    def relu(self, x):
        return np.clip(self.requantised(x), 0, HIGH)


def twice_as_large(x, height, width):
    """Sums of 9 3 3 1 sixteenths, not divided yet: [..., 2h, 2w] cut to height, width."""
    def between(x, axis):
        before = np.concatenate([np.take(x, [0], axis), np.delete(x, -1, axis)], axis)
        after = np.concatenate([np.delete(x, 0, axis), np.take(x, [-1], axis)], axis)
        shape = list(x.shape)
        shape[axis] *= 2
        return np.stack([3 * x + before, 3 * x + after], axis + 1 if axis >= 0 else x.ndim + axis + 1).reshape(shape)

    return between(between(x.astype(np.int64), x.ndim - 2), x.ndim - 1)[..., :height, :width]


def _nearer_at_borders(index):
    around = np.lib.stride_tricks.sliding_window_view(np.pad(index, 1, mode="edge"), (3, 3))
    nearest = around.max((2, 3))
    return np.where(nearest - around.min((2, 3)) > BORDER_Q8, nearest, index)


def _rounded_16(x):
    return (x + 8) >> 4


class IntegerModel:
    """network: a FocusNetwork that rounds (quantisation.py), order focus_first, without IHCA."""

    def __init__(self, network):
        if network.published or len(network.ihca) or not network.median or not network.aggregation.head.active:
            raise ValueError("an integer model is made of a quantised network of order focus_first, without IHCA, with a median")
        a, r = network.aggregation, network.refinement
        self.hypotheses = network.hypotheses
        focus_scale, cost_scale = FOCUS, float(network.cost_scale())
        self.fcd, scale = [], focus_scale
        for i, layer in enumerate(network.fcd.filter):
            self.fcd.append(_conv(layer, scale, float(layer[-1].scale), ZERO if i == 0 else 0))
            scale = float(layer[-1].scale)
        s4, s8, s16 = (float(group[0].scale) for group in a.one_scale())
        self.mix = _conv(a.mix, cost_scale, s4)
        of_cost = self.hypotheses * network.fcd.channels
        self.mix.bias = (self.mix.bias - ZERO * self.mix.weight[:, of_cost:].astype(np.int64).sum((1, 2, 3))).astype(np.int32)
        self.at_4 = _residuals(a.at_4, s4)
        self.down_8, self.at_8 = _conv(a.at_8[0], s4, s8), _residuals(a.at_8[1:], s8)
        self.down_16, self.at_16 = _conv(a.at_16[0], s8, s16), _residuals(a.at_16[1:], s16)
        self.narrow_16, self.up_8 = _conv(a.narrow_16, s16, s8), _residuals(a.up_8, s8)
        self.narrow_8, self.up_4 = _conv(a.narrow_8, s8, s4), _residuals(a.up_4, s4)
        self.head, self.own = _conv(a.head, s4, SCORE), _conv(a.own, cost_scale, SCORE)
        guide = float(r.large_guide.scale)
        self.guide = _conv(r.guide, s4, guide)
        scale = float(r.first[-1].scale)
        self.first = _conv(r.first, float(r.place.scale) / self.hypotheses, scale)
        self.body = []
        for layer in r.body:
            self.body.append(_conv(layer, scale, float(layer[-1].scale)))
            scale = float(layer[-1].scale)
        self.last = _conv(r.last, scale, STEP)

    def __call__(self, focus, context, half, used):
        """focus u8 [D, maps, h, w], context u8 [n, h, w], half u8 [D, h2, w2], used: every tensor by name, the last of them
        index u16 [h2, w2] in 1/256 hypothesis and confidence u8 [h, w]."""
        out = {}
        cost = np.stack([self._focus_cost(plane) for plane in focus])  # [D, c, h, w]
        h, w = cost.shape[2:]
        out["cost"] = cost
        out["a4"] = a4 = self._blocks(self.mix.relu(np.concatenate([cost.reshape(-1, h, w), context])), self.at_4)
        out["a8"] = a8 = self._blocks(self.down_8.relu(a4), self.at_8)
        out["a16"] = a16 = self._blocks(self.down_16.relu(a8), self.at_16)
        out["b8"] = b8 = self._blocks(self._join(a8, self.narrow_16, a16), self.up_8)
        out["b4"] = b4 = self._blocks(self._join(a4, self.narrow_8, b8), self.up_4)
        own = np.stack([self.own.requantised(plane)[0] for plane in cost])
        out["scores"] = scores = self.head.requantised(b4) + own
        out["index_4"], out["confidence"] = self._regression(scores, int(used), context[-2])
        out["index"] = self._refinement(out["index_4"], b4, half, int(used), out)
        return out

    def _focus_cost(self, x):
        for layer in self.fcd:
            x = layer.relu(x)
        return x

    @staticmethod
    def _blocks(x, blocks):
        for first, second in blocks:
            x = np.clip(x + second.requantised(first.relu(x)), 0, HIGH)
        return x

    @staticmethod
    def _join(x, narrow, y):
        small = np.clip(narrow.requantised(y), -128, 127)
        return np.clip(x + _rounded_16(twice_as_large(small, *x.shape[1:])), 0, HIGH).astype(np.int32)

    @staticmethod
    def _regression(scores, used, step_bytes):
        below = scores[:used].max(0) - scores[:used]
        p = EXP[np.minimum(below, len(EXP) - 1)]
        weight = p * (8 * np.arange(used)[:, None, None] + 1)
        below = weight.cumsum(0)
        best = (2 * below < below[-1]).sum(0)
        own = np.take_along_axis(weight, best[None], 0)[0]
        rest = below[-1] - 2 * (np.take_along_axis(below, best[None], 0)[0] - own)
        index = np.clip(256 * best - 128 + (256 * rest + own) // (2 * own), 0, 256 * (used - 1))
        variance = (p * (256 * np.arange(used)[:, None, None] - index) ** 2).sum(0) // p.sum(0)
        spread = np.sqrt(variance.astype(np.float64)).astype(np.int64)  # below 2^28: the root of a square is exact
        step = np.maximum(step_bytes.astype(np.int64) - ZERO, 0)
        trust = 255 * index * step // ((index + spread) * step + ONE_PX)
        return index.astype(np.int64), trust.astype(np.uint8)

    def _refinement(self, index_4, b4, half, used, out):
        h, w = half.shape[1:]
        start = _rounded_16(twice_as_large(index_4[None], h, w))[0]
        place = (start + 64) >> 7
        nearest = (start + 128) >> 8
        planes = []
        for offset in (-1, 0, 1):
            k = nearest + offset
            counts = np.take_along_axis(half, np.clip(k, 0, len(half) - 1)[None], 0)[0].astype(np.int32)
            planes.append(np.minimum(counts, MOST_COUNTS) * ((k >= 0) & (k < len(half))))
        guide = _rounded_16(twice_as_large(self.guide.relu(b4), h, w))
        x = self.first.relu(np.concatenate([place[None], np.stack(planes), guide]))
        for layer in self.body:
            x = layer.relu(x)
        out["refined"] = x
        return _nearer_at_borders(np.clip(start + self.last.requantised(x)[0], 0, 256 * (used - 1))).astype(np.uint16)


def _conv(layer, scale_in, scale_out, zero=0):
    """Of a Conv or ConvBnRelu: scale_in is what one unit of its first input channel is worth."""
    weight, bias = layer.folded()
    columns = getattr(layer, "columns", None)
    _, scale = rounded_weights(weight, columns)
    if columns is not None:
        weight = weight * columns.reshape(1, -1, 1, 1)
    weight, scale = weight.detach().double().numpy(), scale.detach().double().numpy()
    bias = np.zeros(len(scale)) if bias is None else bias.detach().double().numpy()
    # Channels that died in training have weights so small that neither bias nor factor would fit their scale.
    scale = np.maximum(scale, np.maximum(np.abs(bias) / (scale_in * 2.0 ** 30), 2.0 ** -39 * scale_out / scale_in))
    integers = np.clip(np.rint(weight / scale[:, None, None, None]), -127, 127).astype(np.int8)
    conv = layer if hasattr(layer, "stride") else layer[0]
    factor = (scale * scale_in / scale_out).astype(np.float32)
    if not np.all((factor >= 2.0 ** -40) & (factor < 1)):
        raise TrainingError(DIVERGED, f"layer of {conv.in_channels} to {conv.out_channels} channels",
                            "has a scale outside 2^-40 to 1: its sums cannot be requantised.")
    return IntegerConv(integers, np.rint(bias / (scale * scale_in)).astype(np.int32), factor, conv.stride[0], conv.dilation[0],
                       zero)


def _residuals(blocks, scale):
    return [(_conv(block.first, scale, float(block.first[-1].scale)),
             _conv(block.second, float(block.first[-1].scale), scale)) for block in blocks]
