#!/usr/bin/env python3
"""`egofocus eval` against an independent computation with numpy: every metric, pixel set and curve, to 1e-9.

usage: eval_numpy_test.py RECORDING -- COMMAND...       exit code 1 when a number differs, 77 without numpy
"""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

try:
    import numpy as np
except ImportError:
    print("skipped: no numpy. Debian: apt-get install python3-numpy")
    sys.exit(77)

from recording_files import grid_of_sensor, read_evt3, read_png16, write_png16

CUT, CLIP_MIN, CLIP_MAX = 10.0, 0.2, 15.0
SCALE_M = 0.001
ROOTS = ("rmse", "rmse_log")


def check_event_pixels(recording, images, out, checker):
    """The masks against the events themselves. A ray may fall between two pixels to the last digit."""
    t, x, y = read_evt3(recording / "events.raw")
    u, v = grid_of_sensor(recording)
    for image in images:
        window = (t >= image["window_begin_us"]) & (t <= image["t_us"])
        gu, gv = u[y[window], x[window]], v[y[window], x[window]]
        mask = np.load(out / "events" / f"{image['t_us']:012d}.npy") > 0
        inside = (gu >= 0) & (gv >= 0) & (gu < mask.shape[1]) & (gv < mask.shape[0])
        ours = np.zeros(mask.shape, dtype=bool)
        ours[gv[inside], gu[inside]] = True
        checker.compared += 1
        if np.sum(ours != mask) > 3 or not 0 < image["t_us"] - image["window_begin_us"] <= 200000:
            checker.failures += 1
            print(f"error: event pixels at {image['t_us']}: {np.sum(ours != mask)} of {np.sum(ours)} differ")


def metres(raw):
    out = (raw.astype(np.float64) * SCALE_M).astype(np.float32).astype(np.float64)
    out[raw == 65535] = np.inf
    return out


def mean(values):
    return float(np.mean(values)) if len(values) else None


def definition(d, g):
    with np.errstate(divide="ignore"):
        ratio = np.maximum(d / g, g / d)
        log_error = (np.log(d) - np.log(g))[d > 0]
    return {
        "abs_rel": mean(np.abs(d - g) / g),
        "rmse": mean((d - g) ** 2) ** 0.5,
        "rmse_log": mean(log_error ** 2) ** 0.5 if len(log_error) else None,
        "d1": mean(ratio < 1.25), "d2": mean(ratio < 1.25 ** 2), "d3": mean(ratio < 1.25 ** 3),
        "epe": mean(np.abs(d - g)),
        **{f"mae_{far}m": mean(np.abs(d - g)[g < far]) for far in (10, 20, 30)},
    }


def image_metrics(estimate, g, step):
    claimed = np.where(estimate > 0, estimate, np.inf)
    d = np.clip(claimed, CLIP_MIN, CLIP_MAX)
    p = np.where(claimed > 100, 0.0, claimed)
    out = definition(d, g)
    out["sq_rel"] = mean((d - g) ** 2 / g)
    out["idx_mae"] = mean(np.abs(1 / d - 1 / g) / step) if step > 0 else None
    out.update({"paper_" + name: value for name, value in definition(p, g).items()})
    out["paper_sq_rel"] = mean((p - g) ** 2 / g ** 2)
    out["paper_zero_share"] = mean(p == 0)
    return out


def curves(error, confidence):
    by_confidence, by_oracle = [], []
    falling = np.sort(confidence)[::-1]
    rising = np.sort(error)
    for step in range(20):
        keep = len(error) - len(error) * step // 20
        level = falling[keep - 1]
        sure, tied = error[confidence > level], error[confidence == level]
        by_confidence.append((sure.sum() + tied.mean() * (keep - len(sure))) / keep)
        by_oracle.append(rising[:keep].mean())
    return by_confidence, by_oracle


class Checker:
    def __init__(self):
        self.compared = 0
        self.failures = 0

    def equal(self, what, theirs, ours):
        self.compared += 1
        same = theirs is None and ours is None
        if theirs is not None and ours is not None:
            same = abs(theirs - ours) <= 1e-9 * max(abs(ours), 1e-3)
        if not same:
            self.failures += 1
            if self.failures <= 20:
                print(f"error: {what}: egofocus {theirs!r}, numpy {ours!r}")


def mean_of(list_of_metrics, name):
    values = [m[name] for m in list_of_metrics if m[name] is not None]
    return mean(values)


def evaluate(recording, maps, report, checker):
    """`maps`: method -> function (stem) -> (depth, confidence or None)."""
    entry = report["recordings"][0]
    files = {int(path.stem): path for path in sorted((recording / "depth").glob("*.png"), reverse=True)}
    truths, estimates, sets = [], {method: [] for method in maps}, []
    values = []
    for image in entry["images"]:
        path = files[image["t_us"]]
        g = metres(read_png16(path))
        valid = (g > 0) & (g <= CUT)
        values.append(g[valid])
        for method in maps:
            estimates[method].append(maps[method](path.stem))
        truths.append(g)
        step = image["step_per_m"]
        index = np.full(g.shape, -1.0)
        if step > 0:
            index[valid] = 1.0 / g[valid] / step
        inside = (index >= 0.5) & (index <= image["hypotheses"] - 1)
        sets.append((valid, inside, step))
    median = np.sort(np.concatenate(values))[len(np.concatenate(values)) // 2]
    checker.equal("median_m", entry["median_m"], float(median))
    inside_of = [(np.sum(i & v), np.sum(v)) for v, i, step in sets if step > 0]
    checker.equal("outside_ladder", entry["outside_ladder"],
                  1 - sum(a for a, _ in inside_of) / sum(b for _, b in inside_of))
    for method in entry["methods"]:
        if method["method"] == "median":
            estimates["median"] = [(np.full(g.shape, np.float64(np.float32(median))), None) for g in truths]
    events = [maps_events(path) for path in events_files(entry["images"], files)]
    for method in entry["methods"]:
        name = method["method"]
        per_set = {key: [] for key in ("all", "events", "all_in_ladder", "events_in_ladder", "all_common", "events_common")}
        coverage, sparse = [], []
        for k, g in enumerate(truths):
            valid, inside, step = sets[k]
            common = np.logical_and.reduce([estimates[m][k][0] > 0 for m in estimates])
            d, confidence = estimates[name][k]
            for prefix, base in (("all", valid), ("events", valid & events[k])):
                for suffix, mask in (("", base), ("_in_ladder", base & inside), ("_common", base & common)):
                    if entry["images"][k]["pixels"][prefix + suffix] != np.sum(mask):
                        checker.equal(f"{prefix + suffix} pixels at {entry['images'][k]['t_us']}",
                                      entry["images"][k]["pixels"][prefix + suffix], int(np.sum(mask)))
                    if mask.any():
                        per_set[prefix + suffix].append(image_metrics(d[mask], g[mask], step))
            coverage.append(np.mean(d[valid] > 0))
            answered = valid & (d > 0)
            if confidence is not None and answered.any():
                error = np.abs(np.clip(d, CLIP_MIN, CLIP_MAX) - g)[answered] / g[answered]
                sparse.append(curves(error, confidence[answered]))
        checker.equal(f"{name} coverage", method["coverage"], mean(coverage))
        for key, images in per_set.items():
            checker.equal(f"{name} {key} images", method[key]["images"], len(images))
            for metric in method[key]:
                if metric != "images":
                    checker.equal(f"{name} {key} {metric}", method[key][metric],
                                  mean_of(images, metric) if images else None)
        if sparse:
            for which, key in enumerate(("by_confidence", "by_oracle")):
                curve = np.mean([pair[which] for pair in sparse], axis=0)
                for k in range(20):
                    checker.equal(f"{name} {key} {k}", method["sparsification"][key][k], float(curve[k]))
                area = float(np.sum(curve[:-1] + curve[1:]) / 2 / 20)
                checker.equal(f"{name} area of {key}",
                              method["sparsification"]["area" if which == 0 else "oracle_area"], area)
        else:
            assert "sparsification" not in method


def irregular_copy(recording, folder):
    """The same with its truth at times of its own: 10 Hz with jitter, one picture twice, some outside the events."""
    folder.mkdir()
    for path in recording.iterdir():
        if path.name != "depth":
            (folder / path.name).symlink_to(path.resolve())
    (folder / "depth").mkdir()
    random = np.random.default_rng(8)
    times = {}
    for path in sorted((recording / "depth").glob("*.png"))[7::2]:
        t_us = int(path.stem) + int(random.choice([-2900, -3, 1, 17, 4001]))
        (folder / "depth" / f"{t_us:012d}.png").symlink_to(path.resolve())
        times[t_us] = path
    first = sorted(times)[0]
    (folder / "depth" / f"{first}.png").symlink_to(times[first].resolve())
    for t_us in (3_000_000, 3_000_001):
        (folder / "depth" / f"{t_us:012d}.png").symlink_to(times[first].resolve())
    return sorted(times)


def main():
    split = sys.argv.index("--")
    recording, command = pathlib.Path(sys.argv[1]), sys.argv[split + 1:]
    checker = Checker()
    with tempfile.TemporaryDirectory() as folder:
        work = pathlib.Path(folder)

        def run(*options, recording=recording):
            shutil.rmtree(work / "out", ignore_errors=True)
            subprocess.run(command + ["eval", str(recording), "--cut", str(CUT), "--clip", f"{CLIP_MIN}:{CLIP_MAX}",
                                      "--json", str(work / "scores.json"), "--out", str(work / "out"),
                                      *options], check=True, stdout=subprocess.DEVNULL)
            return json.loads((work / "scores.json").read_text())

        out = work / "out" / recording.name

        def written(method, has_confidence):
            def load(stem):
                confidence = np.load(out / method / f"{stem}_confidence.npy") if has_confidence else None
                return np.load(out / method / f"{stem}.npy").astype(np.float64), confidence
            return load

        global maps_events, events_files
        maps_events = lambda path: np.load(path) > 0
        events_files = lambda images, files: [out / "events" / f"{files[i['t_us']].stem}.npy" for i in images]

        # A whole replay, from the standstill into the fastest part.
        report = run("--methods", "focus,focus+sgm,median", "--limit", "19", "--min-confidence", "12")
        assert len(report["recordings"][0]["images"]) == 19
        evaluate(recording, {"focus": written("focus", True), "focus+sgm": written("focus+sgm", True)}, report, checker)

        check_event_pixels(recording, report["recordings"][0]["images"], out, checker)

        # Truth at times of its own, on no grid: all of it is compared, at its very times.
        irregular = work / "irregular"
        times = irregular_copy(recording, irregular)
        report = run("--methods", "focus,median", "--limit", "9", recording=irregular)
        entry = report["recordings"][0]
        counts = [entry[key] for key in ("compared", "after_events", "same_time", "without_tick", "over_limit")]
        assert counts == [9, 2, 1, 0, len(times) - 9], counts
        assert [image["t_us"] for image in entry["images"]] == times[:9]
        assert len(set(t_us % 50000 for t_us in times[:9])) > 3
        assert entry["methods"][0]["all_common"]["images"] > 5
        out = work / "out" / irregular.name
        evaluate(irregular, {"focus": written("focus", True)}, report, checker)
        check_event_pixels(irregular, entry["images"], out, checker)
        out = work / "out" / recording.name

        # Somebody's maps: noisy, with holes and infinity.
        maps = work / "maps"
        maps.mkdir()
        random = np.random.default_rng(5)
        for path in sorted((recording / "depth").glob("*.png")):
            raw = read_png16(path)
            noisy = np.clip(raw * random.uniform(0.5, 6, raw.shape), 1, 65534).astype(np.uint16)
            noisy[random.uniform(size=raw.shape) < 0.1] = 0
            noisy[random.uniform(size=raw.shape) < 0.1] = 65535
            write_png16(maps / path.name, noisy)
        report = run("--methods", "maps,median", "--maps", str(maps), "--first-tick-us", "1450000", "--rate", "10",
                     "--limit", "4")
        assert [image["t_us"] for image in report["recordings"][0]["images"]] == [1450000, 1550000, 1650000, 1750000]
        evaluate(recording, {"maps": lambda stem: (metres(read_png16(maps / f"{stem}.png")), None)}, report, checker)
    print(f"{checker.compared} numbers compared, {checker.failures} differ")
    return 1 if checker.failures or checker.compared < 600 else 0


sys.exit(main())
