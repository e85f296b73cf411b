"""python3 -m egofocus_training.export --config FILE --weights FILE --out DIR: the network for the library, and as ONNX for other engines.

DIR/NAME.efm     the integer model, as the library loads it; NAME: that of the weights' folder, or --name
DIR/float.onnx   the float network
DIR/qdq.onnx     the same with QuantizeLinear and DequantizeLinear where the integer model has bytes, weights per output channel
DIR/vectors.bin  one window's inputs, every intermediate of the integer model by name and its outputs, and PyTorch's outputs of
                 both graphs, raw and little-endian; DIR/vectors.json says where each begins, its type and its shape
Inputs: focus u8 [1, D, maps, h/4, w/4], context u8 [1, n, h/4, w/4], half u8 [1, D, h/2, w/2], used int64 [1]. Outputs: index
[1, h/2, w/2] in hypotheses, confidence [1, h/4, w/4]. `node onnx_runtime/compare.js DIR` runs both in ONNX Runtime. qdq.onnx rounds as
nearly as ONNX can say it: halves to even in up-sampled sums, scores and indices as floats. Both are of one size, --size.
"""
import argparse
import json
import pathlib

import numpy as np
import torch
from torch import nn

from . import checkpoint, efm, errors
from .config import load_config
from .evaluate import load_network
from .integer_model import IntegerModel
from .macs import size_of
from .machine import keep_freed_memory
from .model.bytes import Bytes, Conv, ConvBnRelu, rounded_weights
from .quantisation import is_quantised, set_rounding
from .vectors import random_window

_OPSET = 13


class _Door(nn.Module):
    """Positional inputs and outputs, as ONNX has them."""

    names = ("focus", "context", "half", "used")

    def __init__(self, network):
        super().__init__()
        self.network = network

    def forward(self, *inputs):
        prediction = self.network(dict(zip(self.names, inputs)))
        return prediction.index, prediction.confidence


def _onnx_bytes(point):
    """What stands in for a Bytes in qdq.onnx: a pair of operators for bytes, nothing for int16."""
    if point.high > 127 or point.half_up and point.fixed:
        return lambda x: x
    scale, low, high = float(point.scale), point.low, point.high
    return lambda x: torch.fake_quantize_per_tensor_affine(x, scale, 0, low, high)


def prepare_qdq(network):
    """Puts ONNX's own pairs where bytes are rounded, and rounded weights into the convolutions; returns [(weights int8, scale of
    each output channel)]. The network is for exporting alone afterwards."""
    set_rounding(network, False)
    first = network.refinement.place.scale / network.hypotheses
    units = {network.aggregation.mix: float(network.cost_scale()), network.refinement.first: float(first)}
    for module in network.modules():
        if isinstance(module, Bytes):
            module.forward = _onnx_bytes(module)
    layers = [module for module in network.modules() if isinstance(module, (Conv, ConvBnRelu))]
    return [_fold(layer, units.get(layer)) for layer in layers]


@torch.no_grad()
def _fold(layer, unit):
    """Batch norm goes into the weights. unit: of the first channel's bytes, in which all channels of a mixed input leave."""
    conv = layer if isinstance(layer, Conv) else layer[0]
    weight, bias = layer.folded()
    columns = getattr(layer, "columns", None)
    _, scale = rounded_weights(weight, columns)
    scaled = weight if columns is None else weight * columns.reshape(1, -1, 1, 1)
    whole = torch.round(scaled / scale.reshape(-1, 1, 1, 1)).clamp(-127, 127)
    rounded = (whole * scale.reshape(-1, 1, 1, 1)).detach()
    bias = None if bias is None else bias.detach()
    rest = [] if isinstance(layer, Conv) else list(layer)[2:]

    def forward(x):
        if columns is not None:
            x = torch.fake_quantize_per_tensor_affine(x / columns.reshape(1, -1, 1, 1), unit, 0, -128, 127)
        x = nn.functional.conv2d(x, rounded, bias, conv.stride, conv.padding, conv.dilation, conv.groups)
        for part in rest:
            x = part(x)
        return x

    layer.forward = forward
    return whole.to(torch.int8).numpy(), scale.float().numpy()


def weights_as_bytes(path, layers):
    """Replaces each convolution's float weights by int8 ones with a DequantizeLinear per output channel."""
    import onnx
    from onnx import helper, numpy_helper

    model = onnx.load(str(path))
    graph = model.graph
    constants = {n.output[0]: numpy_helper.to_array(n.attribute[0].t) for n in graph.node if n.op_type == "Constant"}
    constants.update({t.name: numpy_helper.to_array(t) for t in graph.initializer})
    added, waiting = [], list(layers)
    for node in [n for n in graph.node if n.op_type == "Conv"]:
        weight = constants[node.input[1]]
        at = next(i for i, (whole, scale) in enumerate(waiting) if whole.shape == weight.shape
                  and np.allclose(whole * scale[:, None, None, None], weight, rtol=1e-5, atol=1e-7))
        whole, scale = waiting.pop(at)
        name = f"weight_{len(added)}"
        graph.initializer.extend([numpy_helper.from_array(whole, name), numpy_helper.from_array(scale, f"{name}_scale"),
                                  numpy_helper.from_array(np.zeros(len(scale), np.int8), f"{name}_zero")])
        added.append(helper.make_node("DequantizeLinear", [name, f"{name}_scale", f"{name}_zero"], [f"{name}_float"], axis=0))
        node.input[1] = f"{name}_float"
    used = {name for n in graph.node for name in n.input}
    kept = [n for n in graph.node if n.op_type != "Constant" or n.output[0] in used]
    left = [t for t in graph.initializer if t.name in used or t.name.startswith("weight_")]
    del graph.node[:], graph.initializer[:]
    graph.node.extend(added + kept)
    graph.initializer.extend(left)
    onnx.checker.check_model(model)
    onnx.save(model, str(path))


def _batch_of(window):
    return {name: torch.as_tensor(value)[None] for name, value in window.items()}


def write_onnx(network, inputs, path):
    """PyTorch's own outputs, by name, beside the file."""
    arguments, outputs = tuple(inputs[name] for name in _Door.names), ["index", "confidence"]
    door = _Door(network).eval()
    with torch.no_grad():
        own = door(*arguments)
    torch.onnx.export(door, arguments, str(path), opset_version=_OPSET, input_names=list(_Door.names), output_names=outputs)
    return {name: tensor.float().numpy() for name, tensor in zip(outputs, own)}


def write_vectors(arrays, folder):
    """vectors.bin and vectors.json of {name: array}."""
    places, at = {}, 0
    with open(folder / "vectors.bin", "wb") as file:
        for name, array in arrays.items():
            array = np.ascontiguousarray(array)
            data = array.astype(array.dtype.newbyteorder("<")).tobytes()
            places[name] = {"type": array.dtype.name, "shape": list(array.shape), "offset": at}
            file.write(data + bytes(-len(data) % 8))
            at += len(data) + -len(data) % 8
    (folder / "vectors.json").write_text(json.dumps(places, indent=1), encoding="utf-8")


def _export_onnx(network, integers, inputs, out):
    """Names of the files written."""
    tensors = integers(**{name: tensor[0].numpy() for name, tensor in inputs.items()})
    arrays = {f"in_{name}": tensor.numpy() for name, tensor in inputs.items()} | tensors
    set_rounding(network, False)
    own = write_onnx(network, inputs, out / "float.onnx")
    arrays |= {f"float_{name}": array for name, array in own.items()}
    layers = prepare_qdq(network)
    own = write_onnx(network, inputs, out / "qdq.onnx")
    arrays |= {f"qdq_{name}": array for name, array in own.items()}
    weights_as_bytes(out / "qdq.onnx", layers)
    write_vectors(arrays, out)
    return ["float.onnx", "qdq.onnx", "vectors.bin", "vectors.json"]


def main():
    parser = argparse.ArgumentParser(prog="egofocus_training.export", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--config", required=True)
    parser.add_argument("--weights", required=True)
    parser.add_argument("--out", required=True)
    parser.add_argument("--size", default="346x260", help="the working grid, WIDTHxHEIGHT in px")
    parser.add_argument("--name", help="of the model file (default: the weights' folder)")
    parser.add_argument("--efm-only", action="store_true", help="write NAME.efm alone")
    arguments = parser.parse_args()
    width, height = size_of(arguments.size)
    keep_freed_memory()
    config = load_config(arguments.config)
    network = load_network(arguments.weights, config)
    if not is_quantised(network):
        raise errors.TrainingError(errors.CONFIGURATION, arguments.weights, "was trained in floats to the end: it has no integers.")
    out = pathlib.Path(arguments.out)
    out.mkdir(parents=True, exist_ok=True)
    integers = IntegerModel(network)
    name = arguments.name or pathlib.Path(arguments.weights).resolve().parent.name
    card = efm.card_of(name, config, checkpoint.read(arguments.weights))
    written = [f"{name}.efm"]
    efm.write_model(out / written[0], efm.model_bytes(integers, config, card))
    if not arguments.efm_only:
        written += _export_onnx(network, integers, _batch_of(random_window(config, 1, width, height, config.input.hypotheses)), out)
    for name in written:
        print(f"{out / name}  {(out / name).stat().st_size / 1024:.0f} KiB")
    return 0


if __name__ == "__main__":
    errors.run(main)
