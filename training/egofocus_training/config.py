"""What a training is configured with: one TOML file, every key known, every value checked for its type."""
import dataclasses
import pathlib
import tomllib
from dataclasses import dataclass, field

from .errors import CONFIGURATION, FILE, TrainingError
from .focus_input import thousandths
from .samples import FAMILIES


@dataclass
class DataConfig:
    train: list = field(default_factory=list)  # folders of shards, relative to the config file
    validation: list = field(default_factory=list)  # the same; never trained on
    hold_out_every: int = 0  # every n-th shard of `train` is validation instead; 0: none
    validation_samples: int = 300  # evenly spread over the validation shards
    families: list = field(default_factory=list)  # names to train on; empty: all
    limit: int = 0  # train on so many samples, evenly spread; 0: all


@dataclass
class InputConfig:
    """The window's stack and what the network is told of it (docs/integer_model.md)."""
    hypotheses: int = 48
    ladder: str = "parallax"  # or "metric"
    span_px: float = 40.0  # at most 40: citysim's windows reach no further back
    min_parallax_px: float = 5.0
    max_events: int = 80000
    maps: list = field(default_factory=lambda: ["gradient:1", "gradient:3", "gradient:7", "squares:3", "squares:7"])
    floor_events: float = 0.05  # per pixel, thousandths: keeps the ratio of energy and events from noise
    floor_noise: float = 1.0  # thousandths, in standard deviations of what evenly spread events would do


@dataclass
class NetworkConfig:
    order: str = "focus_first"  # or "published"; "recurrent": [recurrent] in place of all but `regression`
    cost_channels: int = 4  # per hypothesis, after focus cost discrimination; 0: the maps as they come
    cost_hidden: int = 8  # between its two convolutions; 0: one convolution
    ihca_blocks: int = 0
    widths: list = field(default_factory=lambda: [64, 96, 128])  # at 1/4, 1/8, 1/16
    blocks: list = field(default_factory=lambda: [1, 2, 2])  # residual blocks on the way down, at each
    up_blocks: list = field(default_factory=lambda: [1, 1])  # on the way up, at 1/4 and 1/8
    stem: int = 32  # published order: channels of the stem at 1/2
    refine_width: int = 16
    refine_dilations: list = field(default_factory=lambda: [1, 2, 4, 1])
    regression: str = "median"  # weighted; or "expectation"


@dataclass
class RecurrentConfig:
    """A network that is told the motion as numbers alone: voxel grids, one after the other (model/recurrent.py)."""
    slices: int = 4  # of equal time
    bins: int = 5  # of each slice
    stem: int = 16  # channels at 1/2
    widths: list = field(default_factory=lambda: [28, 46, 84])  # of the states at 1/4, 1/8, 1/16
    refine_width: int = 12
    refine_dilations: list = field(default_factory=lambda: [1, 2])


@dataclass
class AugmentConfig:
    crop: list = field(default_factory=lambda: [160, 208])  # height, width in px; empty: all
    flip_horizontal: float = 0.5  # probability, with the motion
    flip_vertical: float = 0.0
    velocity_noise: float = 0.1  # largest share; direction alone, the norm is kept (augment.py says why)
    delay_ms: float = 10.0  # largest
    event_drop: float = 0.6  # largest share of events left out
    hot_pixels: float = 0.0005  # largest share of pixels
    slow: float = 0.0  # probability of a slower motion, in a window of up to a second, with background activity
    noise_hz: float = 1.0  # its largest rate, of each pixel
    dim: float = 0.0  # probability of unlit places, instead of event_drop
    span: list = field(default_factory=lambda: [0.7, 1.0])  # the ladder's span is multiplied by this


@dataclass
class LossConfig:
    distribution: float = 1.0  # cross entropy of the truth's histogram over hypotheses
    label_width: float = 0.6  # of that histogram, in hypotheses
    index: float = 0.3  # robust error of the mean index, in hypotheses
    log_depth: float = 1.0  # of the logarithm of inverse depth: far blunders
    log_floor: float = 0.25  # hypotheses added to both before the logarithm, and to the refined index
    refined: float = 1.0  # relative error of the refined depth
    log_square: float = 1.0  # weight of its square beside its absolute value
    coarse: float = 0.3  # weight of the 1/8 head's distribution
    movers: float = 0.0  # weight of pixels on things that move by themselves
    border: float = 0.0  # added to the refined index's weight where depth jumps within a few pixels


@dataclass
class TrainConfig:
    seed: int = 1
    start: str = ""  # weights to begin with, relative to the config file; empty: random ones
    steps: int = 10000
    batch: int = 8
    learning_rate: float = 1e-3
    warmup_steps: int = 200
    weight_decay: float = 1e-2
    ema: float = 0.998
    clip_norm: float = 1.0
    device: str = "cpu"  # or "cuda"
    threads: int = 0  # of the network; 0: all
    workers: int = 1  # processes that stack windows; 0: the training process itself
    ray_cache_mb: int = 512  # of each of them
    bf16: bool = False
    checkpoint_every_s: float = 600.0
    evaluate_every_s: float = 1800.0
    log_every: int = 20


@dataclass
class QuantiseConfig:
    """The integer model's rounding takes part in the last steps (quantisation.py)."""
    last_steps: int = 0  # 0: never
    calibration_batches: int = 24  # that say how far each tensor reaches


@dataclass
class RecordingConfig:
    """A recording that each evaluation also looks at: never trained on, never chosen by. Paths relative to the config file."""
    folder: str = ""
    source: str = ""  # odometry or poses; empty: what its camera.toml says
    reference: str = ""  # npz with depth (m) and valid; empty: its own depth pictures
    at_us: int = 0  # time of the reference
    z_near_m: float = 0.35


@dataclass
class Config:
    data: DataConfig = field(default_factory=DataConfig)
    input: InputConfig = field(default_factory=InputConfig)
    network: NetworkConfig = field(default_factory=NetworkConfig)
    recurrent: RecurrentConfig = field(default_factory=RecurrentConfig)
    augment: AugmentConfig = field(default_factory=AugmentConfig)
    loss: LossConfig = field(default_factory=LossConfig)
    train: TrainConfig = field(default_factory=TrainConfig)
    quantise: QuantiseConfig = field(default_factory=QuantiseConfig)
    recording: RecordingConfig = field(default_factory=RecordingConfig)

    def network_facts(self):
        """What weights depend on: equal facts, same network."""
        facts = {"input": dataclasses.asdict(self.input), "network": dataclasses.asdict(self.network)}
        if self.network.order == "recurrent":
            facts["recurrent"] = dataclasses.asdict(self.recurrent)
        return facts


def _same_kind(value, default):
    if isinstance(default, bool) or isinstance(value, bool):
        return isinstance(value, bool) and isinstance(default, bool)
    if isinstance(default, float):
        return isinstance(value, (int, float))
    return isinstance(value, type(default))


def _fill(target, table, where, name):
    known = {f.name for f in dataclasses.fields(target)}
    for key, value in table.items():
        if key not in known:
            raise TrainingError(CONFIGURATION, where, f"unknown key `{key}` in [{name}]. Known: {', '.join(sorted(known))}")
        default = getattr(target, key)
        if not _same_kind(value, default):
            raise TrainingError(CONFIGURATION, where,
                                f"[{name}] {key} = {value!r} is not a {type(default).__name__}")
        setattr(target, key, float(value) if isinstance(default, float) else value)


def _check(config, where):
    def need(condition, what):
        if not condition:
            raise TrainingError(CONFIGURATION, where, what)

    i, n, a, t = config.input, config.network, config.augment, config.train
    need(8 <= i.hypotheses <= 64 and i.hypotheses % 8 == 0, "[input] hypotheses: a multiple of 8 from 8 to 64")
    need(i.ladder in ("parallax", "metric"), "[input] ladder: parallax or metric")
    unknown = [name for name in config.data.families if name not in FAMILIES]
    need(not unknown, f"[data] families: no family is called {', '.join(map(str, unknown))}; there are {', '.join(FAMILIES)}")
    need(2 <= i.span_px <= 40, "[input] span_px: 2 to 40, as far as citysim's windows reach")
    need(1 <= len(i.maps) <= 8, "[input] maps: 1 to 8")
    for name, low, high in (("floor_events", 0.02, 2), ("floor_noise", 0.1, 8)):
        value = getattr(i, name)
        need(low <= value <= high and thousandths(value) is not None,
             f"[input] {name}: {low} to {high} in whole thousandths, which the integer model keeps exactly")
    for entry in i.maps:
        name, _, side = str(entry).partition(":")
        need(name in ("gradient", "gradient_x", "gradient_y", "squares") and side in ("1", "3", "5", "7"),
             f"[input] maps: `{entry}` is not gradient, gradient_x, gradient_y or squares with :1 :3 :5 :7")
    need(n.order in ("focus_first", "published", "recurrent"), "[network] order: focus_first, published or recurrent")
    need(n.regression in ("median", "expectation"), "[network] regression: median or expectation")
    need(n.cost_channels > 0 or n.order != "published", "[network] cost_channels: the published order needs some")
    need(min(n.cost_channels, n.cost_hidden, n.ihca_blocks) >= 0, "[network] channels and blocks are not negative")
    need(len(n.widths) == 3 and len(n.blocks) == 3 and len(n.up_blocks) == 2,
         "[network] widths and blocks have three entries, up_blocks two")
    r = config.recurrent
    need(1 <= r.slices <= 32 and 2 <= r.bins <= 32, "[recurrent] slices: 1 to 32; bins: 2 to 32")
    need(len(r.widths) == 3 and all(type(w) is int and w > 0 for w in [r.stem, r.refine_width, *r.widths]),
         "[recurrent] stem, refine_width and the three widths are positive")
    need(all(type(d) is int and d > 0 for d in r.refine_dilations), "[recurrent] refine_dilations are positive")
    need(len(a.crop) in (0, 2) and all(c >= 32 and c % 16 == 0 for c in a.crop),
         "[augment] crop: [height, width], multiples of 16 from 32 on, or []")
    need(len(a.span) == 2 and 0.1 <= a.span[0] <= a.span[1] <= 1, "[augment] span: [low, high] within 0.1 to 1")
    need(0 <= a.event_drop < 1, "[augment] event_drop: 0 to below 1")
    need(t.steps > 0 and t.batch > 0 and t.log_every > 0, "[train] steps, batch and log_every are positive")
    need(min(t.workers, t.threads, t.ray_cache_mb, t.warmup_steps) >= 0,
         "[train] workers, threads, ray_cache_mb and warmup_steps are not negative")
    need(t.learning_rate > 0 and t.clip_norm > 0, "[train] learning_rate and clip_norm are positive")
    need(0 <= t.ema < 1, "[train] ema: 0 to below 1")
    need(config.loss.border >= 0, "[loss] border is not negative")
    need(0 <= config.quantise.last_steps <= t.steps and config.quantise.calibration_batches > 0,
         "[quantise] last_steps: 0 to [train] steps; calibration_batches is positive")
    need(config.quantise.last_steps == 0 or n.order == "focus_first", f"[quantise] last_steps: the {n.order} order has no integer form")
    need(t.device in ("cpu", "cuda"), "[train] device: cpu or cuda")


def parse_config(text, where):
    """The Config of a TOML text; TrainingError (CONFIGURATION) names the key."""
    try:
        tables = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise TrainingError(CONFIGURATION, where, f"is not TOML: {error}") from None
    return config_of(tables, where)


def config_of(tables, where):
    """The Config of {section: {key: value}}, as parse_config."""
    config = Config()
    known = {f.name for f in dataclasses.fields(config)}
    for name, table in tables.items():
        if name not in known or not isinstance(table, dict):
            raise TrainingError(CONFIGURATION, where, f"unknown section [{name}]. Known: {', '.join(sorted(known))}")
        _fill(getattr(config, name), table, where, name)
    _check(config, where)
    return config


def load_config(path):
    """As parse_config, of a file; paths become absolute. TrainingError (FILE) when it cannot be read."""
    path = pathlib.Path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise TrainingError(FILE, path, f"cannot be read ({error.strerror}).") from None
    config = parse_config(text, path)
    def beside(name):
        return str((path.parent / name).resolve())

    config.data.train = [beside(folder) for folder in config.data.train]
    config.data.validation = [beside(folder) for folder in config.data.validation]
    if config.train.start:
        config.train.start = beside(config.train.start)
    for name in ("folder", "reference"):
        if getattr(config.recording, name):
            setattr(config.recording, name, beside(getattr(config.recording, name)))
    return config
