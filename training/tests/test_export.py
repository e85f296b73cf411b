"""The exports: what is in the files, and that they are the network."""
import json
import struct
import subprocess
import sys
import zlib

import numpy as np
import pytest
import torch
from test_integer_model import CONFIG, as_batch, quantised, random_inputs  # noqa: F401: a fixture

from egofocus_training import checkpoint, efm, integer_model
from egofocus_training.export import prepare_qdq, weights_as_bytes, write_onnx
from egofocus_training.integer_model import IntegerModel
from egofocus_training.quantisation import set_rounding

onnx = pytest.importorskip("onnx")


@pytest.fixture(scope="module")
def folder(quantised, tmp_path_factory):  # noqa: F811
    config, network = quantised
    path = tmp_path_factory.mktemp("export")
    (path / "c.toml").write_text(CONFIG)
    checkpoint.write(path / "weights.pt", {"network_facts": config.network_facts(), "step": 1, "quantised": True,
                                           "network": network.state_dict()})
    done = subprocess.run([sys.executable, "-m", "egofocus_training.export", "--config", str(path / "c.toml"), "--weights",
                           str(path / "weights.pt"), "--out", str(path / "out"), "--size", "64x48"], capture_output=True, text=True,
                          check=False)
    assert done.returncode == 0, done.stderr
    return path / "out"


def vectors_of(folder):
    places = json.loads((folder / "vectors.json").read_text())
    data = (folder / "vectors.bin").read_bytes()
    return {name: np.frombuffer(data, p["type"], int(np.prod(p["shape"])), p["offset"]).reshape(p["shape"])
            for name, p in places.items()}


def test_the_graphs_hold_what_their_names_say(folder):
    whole = onnx.load(str(folder / "float.onnx"))
    onnx.checker.check_model(whole)
    assert not any("Quantize" in n.op_type for n in whole.graph.node)
    pairs = onnx.load(str(folder / "qdq.onnx"))
    onnx.checker.check_model(pairs)
    made_by = {name: n for n in pairs.graph.node for name in n.output}
    int8 = {t.name for t in pairs.graph.initializer if t.data_type == onnx.TensorProto.INT8}
    convolutions = [n for n in pairs.graph.node if n.op_type == "Conv"]
    assert len(convolutions) == sum(n.op_type == "Conv" for n in whole.graph.node) > 20
    for node in convolutions:
        weights = made_by[node.input[1]]
        assert weights.op_type == "DequantizeLinear" and weights.input[0] in int8


def test_the_vectors_are_the_integer_models_own(folder, quantised):  # noqa: F811
    vectors = vectors_of(folder)
    inputs = {name[3:]: array[0] for name, array in vectors.items() if name.startswith("in_")}
    tensors = IntegerModel(quantised[1])(**inputs)
    assert tensors["index"].max() > 256
    for name, tensor in tensors.items():
        assert np.array_equal(vectors[name], tensor), name
    assert np.abs(vectors["float_index"][0] - tensors["index"] / 256).mean() < 0.5
    assert np.abs(vectors["qdq_index"][0] - tensors["index"] / 256).mean() < 0.05


def test_the_model_file_is_the_integer_model(folder, quantised):  # noqa: F811
    data = (folder / f"{folder.parent.name}.efm").read_bytes()
    config, network = quantised
    assert data == efm.model_bytes(IntegerModel(network), config, efm.card_of(folder.parent.name, config, {"step": 1}))
    magic, version, total, crc, sections = struct.unpack_from("<8s4I", data)
    assert (magic, version, total) == (b"\x89EFM\r\n\x1a\n", 1, len(data)) and crc == zlib.crc32(data[20:])
    places = {kind: data[at:at + size] for kind, _, at, size in struct.iter_unpack("<4I", data[32:32 + 16 * sections])}
    layers = list(struct.iter_unpack("<12I", places[3]))
    expected = efm.layers(IntegerModel(network))
    assert len(layers) == len(expected) > 20
    for (_, outputs, inputs, side, stride, dilation, zero, weights, bias, scale, *_), (name, conv) in zip(layers, expected):
        assert (outputs, inputs, side) == conv.weight.shape[:3] and (stride, dilation, zero) == (conv.stride, conv.dilation, conv.zero)
        stored = np.frombuffer(data, np.int8, conv.weight.size, weights).reshape(outputs, side, side, inputs)
        assert np.array_equal(stored.transpose(0, 3, 1, 2), conv.weight), name
        assert np.array_equal(np.frombuffer(data, "<f4", outputs, scale), conv.scale), name
        # With the zero point in the bias, zeros of padding and all, the sums are the same.
        q = np.random.default_rng(1).integers(0, 128, (inputs, 5, 6))
        plain = integer_model.IntegerConv(conv.weight, np.frombuffer(data, "<i4", outputs, bias), conv.scale, conv.stride, conv.dilation)
        reach = side // 2 * dilation
        padded = np.pad(q, ((0, 0), (reach, reach), (reach, reach)), constant_values=zero)
        inside = plain.sums(padded)[:, reach // stride:, reach // stride:] if stride == 1 else None
        if inside is not None:
            assert np.array_equal(inside[:, :5, :6], conv.sums(q)), name


def test_pairs_are_the_rounding(quantised, tmp_path):  # noqa: F811
    config, network = quantised
    before = {name: tensor.clone() for name, tensor in network.state_dict().items()}
    copy = type(network)(config.input, config.network)
    copy.load_state_dict(before)
    copy.eval()
    inputs = as_batch(random_inputs(config, 30))
    set_rounding(copy, True)
    seen = {}
    for name in ("aggregation.mix", "refinement.first"):  # their inputs mix several scales
        copy.get_submodule(name).register_forward_hook(lambda _, __, out, name=name: seen.setdefault(name, []).append(out.clone()))
    with torch.no_grad():
        rounded = copy(inputs).index
    layers = prepare_qdq(copy)
    pairs = write_onnx(copy, inputs, tmp_path / "q.onnx")["index"]
    assert np.quantile(np.abs(pairs - rounded.numpy()), 0.99) < 0.1
    for name, outputs in seen.items():
        assert (outputs[0] - outputs[1]).abs().mean() < 0.02 * outputs[0].std(), name
    weights_as_bytes(tmp_path / "q.onnx", layers)  # finds every layer's weights in the graph
