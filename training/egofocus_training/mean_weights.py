"""python3 -m egofocus_training.mean_weights --out FILE WEIGHTS WEIGHTS...: the mean of trainings of one network.

Each training ends somewhere on the rim of the same basin, when one began with the weights of another: between them lies lower
ground (Izmailov et al., "Averaging Weights Leads to Wider Optima and Better Generalization", UAI 2018).
"""
import argparse

import torch

from . import checkpoint, errors


def mean(paths):
    """The state of a weights.pt: numbers averaged, everything else as in the last file."""
    states = [checkpoint.read(path) for path in paths]
    last = states[-1]
    for path, state in zip(paths, states):
        for key in ("network_facts", "quantised"):
            if state.get(key) != last.get(key):
                raise errors.TrainingError(errors.CONFIGURATION, path, f"holds another network than {paths[-1]} ({key}).")
        if {n: t.shape for n, t in state["network"].items()} != {n: t.shape for n, t in last["network"].items()}:
            raise errors.TrainingError(errors.CONFIGURATION, path, f"has other tensors than {paths[-1]}.")
    network = {name: torch.stack([state["network"][name] for state in states]).mean(0) if tensor.is_floating_point() else tensor
               for name, tensor in last["network"].items()}
    return {**last, "network": network}


def main():
    parser = argparse.ArgumentParser(prog="egofocus_training.mean_weights", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", required=True, help="a weights.pt")
    parser.add_argument("weights", nargs="+", metavar="WEIGHTS")
    arguments = parser.parse_args()
    state = mean(arguments.weights)
    state.pop("format")
    checkpoint.write(arguments.out, state)
    print(f"{arguments.out}: the mean of {len(arguments.weights)} trainings")
    return 0


if __name__ == "__main__":
    errors.run(main)
