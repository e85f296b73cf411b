"""A sample as the network sees it: the library's stack and focus, and the truth in steps of its ladder."""
import numpy as np

from . import library
from .focus_input import binding_maps
from .targets import borders, coarse_index, histogram, index_of

_JUMP = 1.5  # hypotheses: less is a slope


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


def wanted_arrays(published):
    return ("focus", "context", "half", "counts") if published else ("focus", "context", "half")


def network_inputs(facts, published=False):
    """The network's inputs of one window, as numpy: its wanted_arrays() and how many hypotheses it used."""
    return {name: facts[name] for name in wanted_arrays(published)} | {"used": np.int64(facts["hypotheses"])}


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
        weight_4 = weight_4 * np.float32(1 + loss_config.border * borders(index_4, 1, _JUMP))
    return {"index_2": index_2, "weight_2": weight_2, "index_4": index_4, "weight_4": weight_4,
            "label": histogram(index, weight, 4, hypotheses, loss_config.label_width).astype(np.float16)}
