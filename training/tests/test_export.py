"""The exports: what is in the files, and that they are the network."""
import json
import subprocess
import sys

import numpy as np
import pytest
import torch
from test_integer_model import CONFIG, as_batch, quantised, random_inputs  # noqa: F401: a fixture

from egofocus_training import checkpoint
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
