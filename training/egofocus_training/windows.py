"""A window as the network sees it: the library's stack and focus, and the truth in steps of its ladder."""
import numpy as np

from . import library
from .focus_input import binding_maps
from .targets import borders, coarse_index, histogram, index_of
from .voxels import recurrent_inputs

_JUMP = 1.5  # hypotheses: less is a slope
_INPUTS = {"focus_first": ("focus", "context", "half"), "published": ("focus", "context", "half", "counts"),
           "recurrent": ("slices", "motion", "rays")}


def ladder_of(input_config, z_near_m, span_factor=1.0):
    """The binding's ladder: kind, hypotheses, z_near, span, least parallax."""
    span_px = input_config.span_px * span_factor
    return (input_config.ladder, input_config.hypotheses, z_near_m, span_px, min(input_config.min_parallax_px, span_px))


def stack_sample(sample, input_config, wanted, crop=(0, 0, 0, 0), span_factor=1.0):
    """The binding's facts and arrays of one sample."""
    camera = sample.camera
    return library.stack.stack_window(
        t_us=sample.t_us, x=sample.x, y=sample.y, motion_t_us=sample.motion_t_us, velocity_m_s=sample.velocity_m_s,
        rate_rad_s=sample.rate_rad_s, camera=camera.grid(), distortion=camera.distortion,
        coefficients=list(camera.coefficients), ladder=ladder_of(input_config, sample.z_near_m, span_factor),
        max_events=input_config.max_events, crop=crop, wanted=list(wanted), maps=binding_maps(input_config))


def wanted_arrays(order="focus_first"):
    """What the binding makes of a network's inputs."""
    return () if order == "recurrent" else _INPUTS[order]


def sample_facts(sample, config, more=(), crop=(0, 0, 0, 0), span_factor=1.0):
    """Facts of one sample with the inputs of the configured network, where there is a stack, and `more` of the binding's
    arrays."""
    order = config.network.order
    facts = stack_sample(sample, config.input, (*wanted_arrays(order), *more), crop, span_factor)
    if order == "recurrent" and facts["has_stack"]:
        camera = sample.camera
        pixels = library.stack.grid_pixels(camera=camera.grid(), distortion=camera.distortion,
                                           coefficients=list(camera.coefficients), crop=crop)
        facts |= recurrent_inputs(config.recurrent, facts, (sample.t_us, sample.polarity),
                                  (sample.motion_t_us, sample.velocity_m_s, sample.rate_rad_s), pixels[sample.y, sample.x])
    return facts


def recording_facts(recording, t_us, config, more=()):
    """The same of a recording's window that ends at t_us; times must rise."""
    order = config.network.order
    facts = recording.tick(t_us, [*wanted_arrays(order), *more], binding_maps(config.input))
    if order == "recurrent" and facts["has_stack"]:
        event_t_us, x, y, polarity = recording.events(t_us)
        facts |= recurrent_inputs(config.recurrent, facts, (event_t_us, polarity), recording.motion(t_us),
                                  recording.grid_pixels()[y, x])
    return facts


def network_inputs(facts, order="focus_first"):
    """The network's inputs of one window, as numpy, and how many hypotheses its ladder used."""
    return {name: facts[name] for name in _INPUTS[order]} | {"used": np.int64(facts["hypotheses"])}


def training_targets(sample, facts, crop, loss_config, hypotheses):
    """Index and weight at 1/2 and 1/4, and the histogram at 1/4, of the crop."""
    x, y, width, height = crop if crop[2] else (0, 0, sample.camera.width, sample.camera.height)
    rho = sample.inverse_depth[y:y + height, x:x + width]
    moving = sample.moving[y:y + height, x:x + width]
    index = index_of(rho, facts["step_per_m"], facts["hypotheses"])
    weight = np.where(moving, np.float32(loss_config.movers), np.float32(1))
    index_2, weight_2 = coarse_index(index, weight, 2)
    index_4, weight_4 = coarse_index(index, weight, 4)
    if loss_config.border > 0:
        weight_2 = weight_2 * np.float32(1 + loss_config.border * borders(index_2, 2, _JUMP))
    return {"index_2": index_2, "weight_2": weight_2, "index_4": index_4, "weight_4": weight_4,
            "label": histogram(index, weight, 4, hypotheses, loss_config.label_width).astype(np.float16)}
