"""The network that a configuration means."""
from .network import FocusNetwork
from .recurrent import RecurrentNetwork


def network_of(config):
    if config.network.order == "recurrent":
        return RecurrentNetwork(config.input, config.recurrent, config.network.regression == "median")
    return FocusNetwork(config.input, config.network)
