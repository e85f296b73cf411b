"""Checkpoints: everything that the next step depends on. A file appears whole or not at all."""
import os
import pathlib
import pickle

import torch

from .errors import BAD_FILE, CONFIGURATION, FILE, TrainingError
from .machine import free_bytes

FORMAT = "egofocus training 1"


def write(path, state):
    """Writes `state` with its format mark. TrainingError (FILE) when the disk has too little room, or refuses."""
    path = pathlib.Path(path)
    partial = path.with_name(path.name + ".partial")
    size = sum(t.numel() * t.element_size() for t in _tensors(state))
    left = free_bytes(path.parent)
    if left < 2 * size + (1 << 20):
        raise TrainingError(FILE, path, f"too little disk: {left >> 20} MiB are left, a checkpoint takes {size >> 20} MiB. "
                            "Free some and go on with --resume.")
    try:
        with open(partial, "wb") as file:
            torch.save({"format": FORMAT, **state}, file)
            file.flush()
            os.fsync(file.fileno())
        os.replace(partial, path)
    except OSError as error:
        raise TrainingError(FILE, path, f"cannot be written ({error.strerror}).") from None


def _tensors(value):
    if isinstance(value, torch.Tensor):
        yield value
    elif isinstance(value, dict):
        for entry in value.values():
            yield from _tensors(entry)
    elif isinstance(value, (list, tuple)):
        for entry in value:
            yield from _tensors(entry)


def read(path, device="cpu"):
    """The state of a checkpoint. TrainingError: FILE when it is missing, BAD_FILE when it is none."""
    try:
        state = torch.load(path, map_location=device)
    except OSError as error:
        raise TrainingError(FILE, path, f"cannot be read ({error.strerror}).") from None
    except (RuntimeError, EOFError, pickle.UnpicklingError, KeyError, ValueError):
        raise TrainingError(BAD_FILE, path, "is no checkpoint, or is cut short.") from None
    if not isinstance(state, dict) or state.get("format") != FORMAT:
        raise TrainingError(BAD_FILE, path, f"is no checkpoint of this program ({FORMAT}).")
    return state


def require_same_network(path, state, config):
    """TrainingError (CONFIGURATION) when a checkpoint's weights are those of another network; names the first key."""
    for section, facts in config.network_facts().items():
        for key, value in facts.items():
            theirs = state["network_facts"].get(section, {}).get(key)
            if theirs != value:
                raise TrainingError(CONFIGURATION, path, f"holds another network: [{section}] {key} is {theirs!r} there and "
                                    f"{value!r} in the config. Use its config, or another --out.")


def start_from(path, network):
    """Weights (the average's, where a checkpoint has one) for a network of the same tensors; how it is trained may differ."""
    state = read(path)
    load_weights(network, state.get("average", state["network"]), path)


def load_weights(network, weights, path):
    """load_state_dict; TrainingError (CONFIGURATION) when the program's own stages have changed since."""
    try:
        network.load_state_dict(weights)
    except RuntimeError as error:
        first = str(error).splitlines()[1].strip() if "\n" in str(error) else str(error)
        raise TrainingError(CONFIGURATION, path, f"was written by another version of the network ({first[:120]}).") from None
