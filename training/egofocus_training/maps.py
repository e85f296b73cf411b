"""python3 -m egofocus_training.maps --config FILE --weights FILE --out DIR [--integer] RECORDING...: depth maps of recordings.

A map for each of a recording's depth pictures, at its time and in its scale: DIR/<recording>/<t_us>.png, as
`egofocus eval RECORDING... --maps DIR` reads them. A window without parallax or events has no estimate (0). The recording's own
camera.toml says how near it gets; ladder and maps are the network's.
"""
import argparse
import pathlib
import tomllib

import numpy as np

from . import errors, library
from .config import load_config
from .evaluate import load_network, predicted_index
from .integer_model import IntegerModel
from .journal import Progress
from .machine import keep_freed_memory
from .metrics import enlarge_q8
from .quantisation import is_quantised
from .windows import ladder_of, network_inputs, recording_facts

_Z_NEAR_M, _SCALE_M = 2.0, 0.001  # what the library takes where camera.toml is silent


def depth_picture(index, step_per_m, scale_m):
    """u16: metres / scale_m, 1..65534; 65535 farther than that, index 0 (the sky) included."""
    with np.errstate(divide="ignore"):
        value = np.rint(1.0 / (np.maximum(index, 0) * step_per_m) / scale_m)
    return np.clip(value, 1, 65535).astype(np.uint16)


def camera_numbers(folder):
    """(z_near_m, scale_m) of a recording's camera.toml."""
    path = pathlib.Path(folder) / "camera.toml"
    try:
        tables = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise errors.TrainingError(errors.FILE, path, f"cannot be read ({error.strerror}).") from None
    except tomllib.TOMLDecodeError as error:
        raise errors.TrainingError(errors.BAD_FILE, path, f"is not TOML: {error}") from None
    return tables.get("ladder", {}).get("z_near_m", _Z_NEAR_M), tables.get("depth", {}).get("scale_m", _SCALE_M)


def write_maps(index_of, folder, out, config):
    """(maps, those without an estimate); index_of(facts) -> hypothesis per pixel."""
    from PIL import Image

    z_near_m, scale_m = camera_numbers(folder)
    out.mkdir(parents=True, exist_ok=True)
    try:
        recording = library.stack.Recording(str(folder), None, ladder_of(config.input, z_near_m))
        times = recording.truth_times_us()
        if not times:
            raise errors.TrainingError(errors.FILE, folder, "has no depth pictures: their times say when maps are wanted.")
        empty = 0
        progress = Progress(folder.name, len(times))
        for n, t_us in enumerate(times):
            facts = recording_facts(recording, t_us, config)
            if facts["has_stack"]:
                picture = depth_picture(index_of(facts), facts["step_per_m"], scale_m)
            else:
                width, height = facts["grid"][:2]
                picture = np.zeros((height, width), np.uint16)
                empty += 1
            Image.fromarray(picture).save(out / f"{t_us:012d}.png")
            progress.show(n + 1)
        progress.end()
    except library.stack.StackError as error:
        raise errors.TrainingError(errors.FILE, folder, str(error)) from None
    except OSError as error:
        raise errors.TrainingError(errors.FILE, out, f"cannot be written ({error.strerror}).") from None
    return len(times), empty


def main():
    parser = argparse.ArgumentParser(prog="egofocus_training.maps", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--config", required=True)
    parser.add_argument("--weights", required=True)
    parser.add_argument("--out", required=True)
    parser.add_argument("--integer", action="store_true", help="by the integer model in place of floats")
    parser.add_argument("recordings", nargs="+", metavar="RECORDING")
    arguments = parser.parse_args()
    keep_freed_memory()
    config = load_config(arguments.config)
    network = load_network(arguments.weights, config)
    if arguments.integer and not is_quantised(network):
        raise errors.TrainingError(errors.CONFIGURATION, arguments.weights, "was trained in floats to the end: it has no integers.")
    model = IntegerModel(network) if arguments.integer else None

    def index_of(facts):
        if model is None:
            return predicted_index(network, facts, config)
        width, height = facts["grid"][:2]
        return enlarge_q8(model(**network_inputs(facts))["index"], height, width) / 256.0

    for name in arguments.recordings:
        folder = pathlib.Path(name)
        maps, empty = write_maps(index_of, folder, pathlib.Path(arguments.out) / folder.name, config)
        print(f"{folder.name}: {maps} maps, {empty} of them without an estimate")
    return 0


if __name__ == "__main__":
    errors.run(main)
