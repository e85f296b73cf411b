"""python3 -m egofocus_training.compare --plan FILE --out DIR [--json]: short trainings of several networks, side by side.

A plan is a TOML file: `base`, a configuration beside it; `seeds`; and a table [variant.NAME] of what each variant changes
in the base, section by section (or a `base` of its own). Each variant is trained once per seed on the same samples and judged
on the same validation windows. What is finished is kept in DIR: run again to go on, or to print the table alone.
"""
import argparse
import copy
import json
import os
import pathlib
import statistics
import sys
import tomllib

import torch

from . import errors
from .config import config_of, load_config
from .evaluate import evaluate, validation_samples
from .journal import Progress
from .machine import keep_freed_memory
from .macs import layer_table, totals
from .samples import split_shards
from .trainer import Trainer

_METRICS = ("d1", "abs_rel", "rmse_log", "idx_mae")


def read_toml(path):
    try:
        return tomllib.loads(pathlib.Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise errors.TrainingError(errors.FILE, path, f"cannot be read ({error.strerror}).") from None
    except tomllib.TOMLDecodeError as error:
        raise errors.TrainingError(errors.CONFIGURATION, path, f"is not TOML: {error}") from None


def read_plan(path):
    """({variant: Config}, seeds). TrainingError names what is wrong."""
    path = pathlib.Path(path)
    plan = read_toml(path)
    unknown = set(plan) - {"base", "seeds", "variant", "all"}
    seeds, variants = plan.get("seeds"), plan.get("variant")
    if unknown or not isinstance(plan.get("base"), str):
        raise errors.TrainingError(errors.CONFIGURATION, path, f"wants base, seeds, [all] and [variant.NAME], not {sorted(unknown)}.")
    if not isinstance(seeds, list) or not seeds or not all(type(s) is int and s >= 0 for s in seeds):
        raise errors.TrainingError(errors.CONFIGURATION, path, "seeds: a list of whole numbers.")
    if not isinstance(variants, dict) or not variants:
        raise errors.TrainingError(errors.CONFIGURATION, path, "names no [variant.NAME].")
    configs = {}
    for name, changes in variants.items():
        changes = dict(changes)
        base = path.parent / changes.pop("base", plan["base"])
        load_config(base)  # complains of the base by its own name
        tables = copy.deepcopy(read_toml(base))
        for overlay in (plan.get("all", {}), changes):
            for section, values in overlay.items():
                if not isinstance(values, dict):
                    raise errors.TrainingError(errors.CONFIGURATION, path, f"[variant.{name}] {section}: a table is wanted.")
                tables.setdefault(section, {}).update(values)
        configs[name] = config_of(tables, f"{path} [variant.{name}]")
        for key in ("train", "validation"):
            folders = getattr(configs[name].data, key)
            setattr(configs[name].data, key, [str((path.parent / folder).resolve()) for folder in folders])
    return configs, seeds


def train_once(config, seed, name):
    """What one training came to: metrics over all validation pixels and over event pixels, samples seen, seconds."""
    config = copy.deepcopy(config)
    config.train.seed = seed
    paths, _ = split_shards(config.data)
    windows = validation_samples(config, name)
    trainer = Trainer(config, lambda: paths)
    progress = Progress(f"{name}, seed {seed}", config.train.steps)

    def after_step(terms):
        progress.show(trainer.step, f"loss {terms['loss']:.3f}")

    trainer.run(config.train.steps, after_step)
    progress.end()
    rows, _ = evaluate(trainer.average.network, windows, config, classical=False)
    result = {"variant": name, "seed": seed, "samples": trainer.step * config.train.batch,
              "seconds": round(trainer.seconds, 1), "facts": config.network_facts(), "rows": rows}
    for row in rows:
        if row["family"] == "overall":
            result[row["set"]] = {metric: row[metric] for metric in _METRICS}
    return result


def summary(configs, results):
    """One dict per variant: cost, mean and standard deviation over seeds."""
    table = []
    for name, config in configs.items():
        cost = totals(layer_table(config, 346, 260))
        mine = [r for r in results if r["variant"] == name]
        row = {"variant": name, "mmac": round(cost["macs"] / 1e6), "weight_kib": round(cost["weight_bytes"] / 1024),
               "seeds": len(mine), "samples": mine[0]["samples"], "seconds": round(statistics.mean(r["seconds"] for r in mine))}
        for pixel_set in ("all", "events"):
            for metric in _METRICS:
                values = [r[pixel_set][metric] for r in mine]
                row[f"{metric}_{pixel_set}"] = [statistics.mean(values), statistics.stdev(values) if len(values) > 1 else 0.0]
        table.append(row)
    return table


def table_text(rows):
    columns = [f"{metric}_{pixel_set}" for pixel_set in ("all", "events") for metric in ("d1", "abs_rel", "rmse_log")]
    width = max(len("variant"), *(len(r["variant"]) for r in rows))
    lines = [f"{'variant':{width}} {'MMAC':>5} {'KiB':>5} {'samples':>8} {'seeds':>5} " + " ".join(f"{c:>15}" for c in columns)]
    for r in rows:
        cells = (f"{'%.3f +- %.3f' % tuple(r[c]):>15}" for c in columns)
        lines.append(f"{r['variant']:{width}} {r['mmac']:5} {r['weight_kib']:5} {r['samples']:8} {r['seeds']:5} " + " ".join(cells))
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(prog="egofocus_training.compare", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--plan", required=True)
    parser.add_argument("--out", required=True, help="folder of one JSON file per finished training")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    keep_freed_memory()
    configs, seeds = read_plan(arguments.plan)
    out = pathlib.Path(arguments.out)
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise errors.TrainingError(errors.FILE, out, f"cannot be made ({error.strerror}).") from None
    results = []
    for seed in seeds:
        for name, config in configs.items():
            if config.train.threads > 0:
                torch.set_num_threads(config.train.threads)
            file = out / f"{name}_{seed}.json"
            if file.exists():
                result = json.loads(file.read_text(encoding="utf-8"))
                if result["facts"] != config.network_facts():
                    raise errors.TrainingError(errors.CONFIGURATION, file, "is of another network than the plan's. Delete it, "
                                               "or name another folder.")
            else:
                result = train_once(config, seed, name)
                partial = file.with_suffix(".partial")
                partial.write_text(json.dumps(result), encoding="utf-8")
                os.replace(partial, file)
                print(f"{name}, seed {seed}: d1 {result['all']['d1']:.3f}", file=sys.stderr)
            results.append(result)
    rows = summary(configs, results)
    print(json.dumps(rows) if arguments.json else table_text(rows))
    return 0


if __name__ == "__main__":
    errors.run(main)
