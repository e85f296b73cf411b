"""From the float network to one whose numbers the integer model can hold: scales from what is seen, then rounding everywhere.

Weights, biases and scales stay floats here, so that training can go on; integer_model.py takes the integers out.
"""
import torch

from .errors import CONFIGURATION, TrainingError
from .model.bytes import Bytes, Conv, ConvBnRelu
from .model.refinement import COUNT
from .units import CONTEXT


def is_quantised(network):
    return any(module.active for module in network.modules() if isinstance(module, Bytes))


@torch.no_grad()
def calibrate(network, batches):
    """Sets every scale from what these batches of inputs (dicts of tensors) make the network's tensors reach."""
    if network.published:
        raise TrainingError(CONFIGURATION, "[network] order", "the published order has no integer form: use focus_first.")
    points = [m for m in network.modules() if isinstance(m, Bytes)]
    training = network.training
    network.eval()
    for point in points:
        point.seen = []
    for batch in batches:
        network(batch)
    groups = network.one_scale()
    grouped = {point for group in groups for point in group}
    for group in groups + [[point] for point in points if point not in grouped]:
        scale = max(max(point.seen) / point.high for point in group)
        for point in group:
            if not point.fixed:
                point.scale.fill_(max(scale, 1e-6))
    for point in points:
        point.seen = None
    set_columns(network)
    network.train(training)


@torch.no_grad()
def set_columns(network):
    """What input channels of another scale are multiplied by before their weights are rounded."""
    cost = network.cost_scale()
    mix = network.aggregation.mix
    of_cost = network.fcd.channels * network.hypotheses
    mix.columns[:of_cost] = 1.0
    mix.columns[of_cost:] = CONTEXT / cost
    first = network.refinement.first
    place = network.refinement.place.scale / network.hypotheses
    first.columns[0] = 1.0
    first.columns[1:4] = COUNT / place
    first.columns[4:] = network.refinement.large_guide.scale / place


def set_rounding(network, active):
    """While it rounds, batch norm is part of the convolutions and does not change any more."""
    for module in network.modules():
        if isinstance(module, (Bytes, Conv, ConvBnRelu)):
            module.active = active
