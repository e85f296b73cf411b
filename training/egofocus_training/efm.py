"""The model file (.efm, docs/formats.md): what the library loads. Integers of an IntegerModel and the facts of its input."""
import binascii
import os
import pathlib
import struct

import numpy as np

from . import errors
from .focus_input import parse_maps, thousandths

VERSION = 1
_MAGIC = b"\x89EFM\r\n\x1a\n"
_ALIGNMENT = 16
_FACTS, _CARD, _LAYERS, _DATA = 1, 2, 3, 4
_CONVOLUTION, _MEDIAN = 1, 1
_MAPS = ("gradient", "gradient_x", "gradient_y", "squares")
_LADDERS = ("parallax", "metric")
_MOST_MAPS, _MOST_DILATIONS, _MOST_BIAS = 8, 8, 2 ** 30


def layers(model):
    """[(name, convolution)], in the order they run."""
    def blocks(name, pairs):
        return [(f"{name}.{i}.{part}", conv) for i, pair in enumerate(pairs) for part, conv in zip(("first", "second"), pair)]

    return [*((f"fcd.{i}", conv) for i, conv in enumerate(model.fcd)), ("mix", model.mix), *blocks("at_4", model.at_4),
            ("down_8", model.down_8), *blocks("at_8", model.at_8), ("down_16", model.down_16), *blocks("at_16", model.at_16),
            ("narrow_16", model.narrow_16), *blocks("up_8", model.up_8), ("narrow_8", model.narrow_8),
            *blocks("up_4", model.up_4), ("head", model.head), ("own", model.own), ("guide", model.guide),
            ("first", model.first), *((f"body.{i}", conv) for i, conv in enumerate(model.body)), ("last", model.last)]


def _padded(data):
    return data + bytes(-len(data) % _ALIGNMENT)


def _facts(config, grid):
    i, n = config.input, config.network
    maps = b"".join(bytes([_MAPS.index(name), side]) for name, side in parse_maps(i.maps))
    return struct.pack("<dd6I16s2I2I3I3I2I3I8sI", i.span_px, min(i.min_parallax_px, i.span_px), _LADDERS.index(i.ladder),
                       i.hypotheses, i.max_events, thousandths(i.floor_events), thousandths(i.floor_noise), len(i.maps),
                       maps.ljust(2 * _MOST_MAPS, b"\0"), *grid, 2 if n.cost_hidden else 1, n.cost_channels, *n.widths, *n.blocks,
                       *n.up_blocks, n.refine_width, _MEDIAN, len(n.refine_dilations),
                       bytes(n.refine_dilations).ljust(_MOST_DILATIONS, b"\0"), n.cost_hidden)


def _data_of(name, conv):
    """(weights s8 [O][y][x][I], biases with the zero point in them, scales) as bytes."""
    bias = conv.bias.astype(np.int64) - conv.zero * conv.weight.astype(np.int64).sum((1, 2, 3))
    if np.abs(bias).max() > _MOST_BIAS:
        raise errors.TrainingError(errors.DIVERGED, name, "has a bias beyond 2^30: its sums could overflow.")
    return conv.weight.transpose(0, 2, 3, 1).tobytes(), bias.astype("<i4").tobytes(), conv.scale.astype("<f4").tobytes()


def model_bytes(model, config, card, grid=(0, 0)):
    """card: text, one `key: value` a line. grid: (width, height) that the model is for alone; 0: any."""
    records = layers(model)
    text = card.encode("utf-8")
    sizes = {_FACTS: 128, _CARD: len(text), _LAYERS: 48 * len(records), _DATA: 0}
    at = 32 + 16 * len(sizes)
    begins = {}
    for kind in (_FACTS, _CARD, _LAYERS, _DATA):
        at += -at % _ALIGNMENT
        begins[kind] = at
        at += sizes[kind]
    table, data = b"", b""
    for name, conv in records:
        outputs, inputs, side, _ = conv.weight.shape
        offsets = []
        for part in _data_of(name, conv):
            offsets.append(begins[_DATA] + len(data))
            data += _padded(part)
        table += struct.pack("<12I", _CONVOLUTION, outputs, inputs, side, conv.stride, conv.dilation, conv.zero, *offsets, 0, 0)
    sizes[_DATA] = len(data)
    body = {_FACTS: _facts(config, grid), _CARD: text, _LAYERS: table, _DATA: data}
    out = bytearray(begins[_DATA])
    for n, kind in enumerate(body):
        struct.pack_into("<4I", out, 32 + 16 * n, kind, 0, begins[kind], sizes[kind])
    for kind in (_FACTS, _CARD, _LAYERS):
        out[begins[kind]:begins[kind] + sizes[kind]] = body[kind]
    out += data
    struct.pack_into("<8sIIIIII", out, 0, _MAGIC, VERSION, len(out), 0, len(body), 0, 0)
    struct.pack_into("<I", out, 16, binascii.crc32(out[20:]))
    return bytes(out)


def card_of(name, config, state):
    """What a model's user wants to know of its training. state: of the weights file."""
    n, t = config.network, config.train
    lines = [f"name: {name}", f"training steps: {state.get('step', 0)} of {t.batch} crops, seed {t.seed}",
             f"steps with rounding: {config.quantise.last_steps}",
             f"trained on: {' '.join(pathlib.PurePath(path).name for path in config.data.train) or 'nothing'}",
             f"widths: {' '.join(map(str, n.widths))}", f"maps: {' '.join(config.input.maps)}"]
    return "\n".join(lines) + "\n"


def write_model(path, data):
    """Whole or not at all. TrainingError (FILE) when it cannot be written."""
    path = pathlib.Path(path)
    partial = path.with_name(path.name + ".partial")
    try:
        partial.write_bytes(data)
        os.replace(partial, path)
    except OSError as error:
        raise errors.TrainingError(errors.FILE, path, f"cannot be written ({error.strerror}).") from None
