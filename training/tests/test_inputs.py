"""From events to tensors: focus where the truth is, mirrors that agree, normalisation and targets by hand."""
import dataclasses
import types

import numpy as np
import pytest
import small_world
from focus_reference import displacement_px, float_sharpness

from egofocus_training.augment import (add_hot_pixels, add_noise, augment, dim, drop_events, flip_horizontal, flip_vertical,
                                       noisy_motion, slow_down)
from egofocus_training.config import AugmentConfig, InputConfig, LossConfig
from egofocus_training.focus_input import context_channels
from egofocus_training.library import stack
from egofocus_training.samples import parse_sample
from egofocus_training.targets import borders, coarse_index, histogram, index_of
from egofocus_training.units import ZERO
from egofocus_training.windows import network_inputs, stack_sample, training_targets, wanted_arrays

# 16 px at 1 m: 16 of span reach z_near = 1 m with hypothesis 15.
CONFIG = InputConfig(hypotheses=16, span_px=16.0)


def sample_of(*arguments, **keywords):
    return parse_sample(small_world.record(*arguments, **keywords), "test")


def test_the_ladder_and_the_focus_are_where_the_wall_is():
    sample = sample_of(2.0)
    facts = stack_sample(sample, CONFIG, ["half", "cells", "focus", "context", "counts", "argmax", "event_mask"])
    assert facts["has_stack"] and facts["hypotheses"] == 16
    assert facts["step_per_m"] == pytest.approx(1 / 15, rel=1e-2)  # 16 px = 1 m * f * 0.2 s * 1 m/s, to one knot of 127
    assert facts["baseline_m"] == pytest.approx((-0.2, 0, 0), abs=2e-3)
    truth = 0.5 / facts["step_per_m"]
    focus, context = facts["focus"], facts["context"]
    assert focus.shape == (16, 5, 20, 24) and context.shape == (context_channels(CONFIG), 20, 24)
    inner = focus[:, :, 3:-3, 6:-6].astype(int)
    best = inner[:, 2].argmax(axis=0)  # gradient, support 7
    assert abs(np.median(best) - truth) <= 0.5 and np.mean(np.abs(best - truth) <= 1) > 0.9
    argmax = facts["argmax"][12:-12, 24:-24] / 256
    assert abs(np.median(argmax) - truth) < 0.3
    counts = facts["counts"].astype(int)
    assert counts[0].sum() <= sample.t_us.size
    half = counts[3].reshape(40, 2, 48, 2).sum(axis=(1, 3))
    assert np.array_equal(facts["half"][3], np.minimum(half, 255))
    assert np.array_equal(facts["cells"][3, 3], counts[3].reshape(20, 4, 24, 4).sum(axis=(1, 3)))
    events = np.zeros((80, 96), bool)
    inside = sample.t_us >= facts["begin_us"]
    events[sample.y[inside], sample.x[inside]] = True
    assert np.array_equal(facts["event_mask"] > 0, events)


def test_hypotheses_that_the_ladder_left_out_are_zero():
    facts = stack_sample(sample_of(4.0, z_near_m=3.0), CONFIG, wanted_arrays())
    assert facts["hypotheses"] == 8
    focus, context = facts["focus"], facts["context"]
    assert np.all(focus[8:] == ZERO) and np.any(focus[:8] != ZERO) and not facts["half"][8:].any()
    assert np.all(context[-1] == ZERO + 16)  # K / D = 1/2 in steps of 1/32


@pytest.mark.parametrize("flip, axis", [(flip_horizontal, 2), (flip_vertical, 1)])
def test_a_mirrored_sample_has_the_mirrored_stack(flip, axis):
    sample = sample_of(1.5, near=(20, 50, 1.1), distortion=1, coefficients=(-0.2, 0.05, 0.003, -0.002, 0.01))
    sample = dataclasses.replace(sample, velocity_m_s=sample.velocity_m_s + np.float32([0, 0.2, 0.3]),
                                 rate_rad_s=sample.rate_rad_s + np.float32([0.1, -0.2, 0.3]))
    straight = stack_sample(sample, CONFIG, ["counts"])
    mirrored = stack_sample(flip(sample), CONFIG, ["counts"])
    assert mirrored["step_per_m"] == pytest.approx(straight["step_per_m"], rel=1e-9)
    a = straight["counts"].astype(int)
    b = np.flip(mirrored["counts"].astype(int), axis)
    assert a.sum() > 50_000
    assert np.abs(a - b).sum() < 1e-3 * a.sum()  # half-way positions round to the other side
    assert np.array_equal(np.flip(flip(sample).inverse_depth, axis - 1), sample.inverse_depth)
    assert np.array_equal(flip(flip(sample)).x, sample.x) and flip(flip(sample)).camera.cx == sample.camera.cx


def test_noise_keeps_the_speed_and_drops_are_counted():
    sample = sample_of(2.0)
    random = np.random.default_rng(1)
    noisy = noisy_motion(sample, 0.1, 7000, random)
    speed = np.linalg.norm(noisy.velocity_m_s, axis=1)
    assert speed.mean() == pytest.approx(1.0, rel=1e-5)
    assert 0.001 < np.abs(noisy.velocity_m_s[0, 1:]).max() < 0.3
    assert noisy.motion_t_us[0] == -193000
    assert np.array_equal(noisy_motion(sample, 0.0, 0, random).velocity_m_s, sample.velocity_m_s)
    left = drop_events(sample, 0.25, random).t_us.size / sample.t_us.size
    assert left == pytest.approx(0.75, abs=0.02)
    hot = add_hot_pixels(sample, 0.01, random)
    assert hot.t_us.size > sample.t_us.size and np.all(np.diff(hot.t_us) >= 0) and hot.x.max() < 96


def test_a_slower_way_has_the_same_stack():
    sample = sample_of(2.0)
    slow = slow_down(sample, 4.0)
    assert slow.window_us == 4 * sample.window_us and slow.velocity_m_s[0, 0] == sample.velocity_m_s[0, 0] / 4
    facts, slow_facts = (stack_sample(s, CONFIG, ["counts"]) for s in (sample, slow))
    assert slow_facts["begin_us"] == pytest.approx(4 * facts["begin_us"], abs=4)
    assert slow_facts["step_per_m"] == pytest.approx(facts["step_per_m"], rel=1e-4)
    a, b = (f["counts"].astype(int) for f in (facts, slow_facts))
    assert a.sum() > 50_000 and np.abs(a - b).sum() < 1e-2 * a.sum()


def test_background_activity_has_its_rate_everywhere():
    sample = dataclasses.replace(sample_of(2.0), window_us=200_000)
    noisy = add_noise(sample, 50.0, np.random.default_rng(1))
    more = noisy.t_us.size - sample.t_us.size
    pixels = sample.camera.width * sample.camera.height
    assert more == pytest.approx(50.0 * 0.2 * pixels, rel=0.05)
    assert np.all(np.diff(noisy.t_us) >= 0) and noisy.t_us.min() >= -200_000
    before, after = (np.bincount(s.y.astype(int) * s.camera.width + s.x, minlength=pixels) for s in (sample, noisy))
    assert np.mean(after > before) > 0.99
    assert np.mean(noisy.polarity) == pytest.approx((sample.polarity.sum() + more / 2) / noisy.t_us.size, abs=0.02)


def test_dim_places_are_large_and_nothing_is_added():
    sample = add_noise(dataclasses.replace(sample_of(2.0), window_us=200_000), 500.0, np.random.default_rng(1))
    left = dim(sample, np.random.default_rng(3))

    def tiles(s):
        return np.histogram2d(s.y, s.x, [4, 6], [[0, s.camera.height], [0, s.camera.width]])[0]
    share = tiles(left) / tiles(sample)
    assert share.min() < 0.1 and share.max() > 0.9 and np.all(np.diff(left.t_us) >= 0)


def test_augmentation_depends_on_its_generators_alone():
    config = AugmentConfig(crop=[48, 64], slow=0.5, dim=0.5)
    first, second = ([augment(sample_of(2.0), config, np.random.default_rng(s), np.random.default_rng(9)) for s in (3, 3, 4)]
                     for _ in range(2))
    assert np.array_equal(first[0][0].t_us, second[1][0].t_us) and first[0][1:] == second[1][1:]
    assert first[0][1:] != first[2][1:]
    x, y, width, height = first[0][1]
    assert (width, height) == (64, 48) and 0 <= x <= 32 and 0 <= y <= 32 and 0.7 <= first[0][2] <= 1


def test_normalisation_by_hand():
    config = InputConfig(floor_events=0.5, floor_noise=1.0)
    energy = np.array([8.0, 16.0, 0.0, 8.0]).reshape(4, 1, 1)
    counts = np.full((4, 1, 1), 8.0)  # 16 px: density 1/2
    z, contrast = float_sharpness(energy, counts, 1, config)
    ratio = np.array([0.5, 1.0, 0.0, 0.5])  # E / (S + 16 * 0.5)
    sd, q = np.sqrt(0.125), np.sqrt(4 / (16 * (0.5 + 0.5)))
    assert z.ravel() == pytest.approx((ratio - 0.5) / (sd + q), rel=1e-6)
    assert contrast.item() == pytest.approx(np.log2(1 + sd / q) / 4, rel=1e-6)


def test_displacement_of_one_hypothesis():
    facts = {"grid": (96, 80, 80.0, 90.0, 47.5, 39.5), "baseline_m": (-0.2, 0.1, 0.4), "step_per_m": 0.5}
    columns, rows = displacement_px(facts)
    assert columns.shape == (24,) and rows.shape == (20,)
    u, v = 4 * 5 + 1.5, 4 * 7 + 1.5
    assert (columns[5], rows[7]) == pytest.approx([80 * -0.1 - 0.2 * (u - 47.5), 90 * 0.05 - 0.2 * (v - 39.5)])


def test_index_and_its_cells():
    assert index_of(np.array([0.0, 0.25, 9.0]), 0.1, 16).tolist() == [0, 2.5, 15]
    index = np.array([[1, 2, 9], [3, 4, 9], [5, 6, 7]], np.float32)
    weight = np.ones_like(index)
    weight[0, 0] = 0
    value, share = coarse_index(index, weight, 2)
    assert value.tolist() == [[3, 9], [5, 7]]  # of 2 3 4; 9 9; 5 6; 7: the lower median
    assert share.tolist() == [[0.75, 0.5], [0.5, 0.25]]
    assert coarse_index(index, np.zeros_like(index), 2)[1].tolist() == [[0, 0], [0, 0]]


def test_borders_are_jumps_and_no_slopes():
    index = np.array([[1, 1.4, 1.8, 2.2, 6, 6], [1, 1.4, 1.8, 2.2, 6, 6]], np.float32)
    assert borders(index, 1, 1.5).tolist() == [[False, False, False, True, True, False]] * 2
    assert borders(index.T, 2, 1.5)[:, 0].tolist() == [False, False, True, True, True, True]


def test_histogram_by_hand():
    index = np.array([[2.25, 6.0]], np.float32).repeat(1, 0)
    label = histogram(index, np.ones_like(index), 2, 8, 1e-3)[:, 0, 0]  # no spread beyond the neighbours
    assert label == pytest.approx([0, 0, 0.375, 0.125, 0, 0, 0.5, 0], abs=1e-6)
    spread = histogram(index, np.array([[1.0, 0.0]], np.float32), 2, 8, 1.0)[:, 0, 0]
    raw = np.array([0.75 * np.exp(-abs(k - 2)) * (abs(k - 2) < 5) + 0.25 * np.exp(-abs(k - 3)) * (abs(k - 3) < 5)
                    for k in range(8)])
    assert spread == pytest.approx(raw / raw.sum(), rel=1e-5)
    assert not histogram(index, np.zeros_like(index), 2, 8, 1.0).any()


def test_targets_of_a_crop():
    sample = sample_of(2.0)
    crop = (0, 0, 64, 48)
    facts = stack_sample(sample, CONFIG, wanted_arrays(), crop)
    targets = training_targets(sample, facts, crop, LossConfig(movers=0.25), 16)
    assert targets["index_2"].shape == (24, 32) and targets["label"].shape == (16, 12, 16)
    assert targets["weight_4"][0, 0] == 0.25 and targets["weight_4"][2, 2] == 1
    assert np.allclose(targets["index_4"], 0.5 / facts["step_per_m"], rtol=1e-3)
    inputs = network_inputs(facts)
    assert inputs["focus"].shape[2:] == (12, 16) and inputs["half"].shape == (16, 24, 32)


def test_borders_weigh_more_where_the_refinement_looks():
    sample = sample_of(2.0, near=(20, 50, 1.1))
    facts = stack_sample(sample, CONFIG, wanted_arrays())
    plain, weighted = (training_targets(sample, facts, (0, 0, 0, 0), LossConfig(border=b), 16) for b in (0.0, 3.0))
    more = weighted["weight_2"] / np.maximum(plain["weight_2"], 1e-9)
    assert more[20, 10] == more[20, 24] == 4 and more[20, 17] == 1  # columns 20 and 50 of 96; between them the near wall
    assert np.array_equal(plain["weight_4"], weighted["weight_4"])


def test_what_cannot_be_stacked_says_why():
    sample = sample_of(2.0)
    with pytest.raises(stack.StackError, match="does not lie in the grid"):
        stack_sample(sample, CONFIG, [], (90, 0, 32, 32))
    with pytest.raises(stack.StackError, match="hypotheses"):
        stack_sample(sample, types.SimpleNamespace(**{**vars(CONFIG), "hypotheses": 36}), [])
    still = dataclasses.replace(sample, velocity_m_s=np.zeros_like(sample.velocity_m_s))
    assert not stack_sample(still, CONFIG, ["half"])["has_stack"]
    with pytest.raises(stack.StackError, match="must rise"):
        stack_sample(dataclasses.replace(sample, motion_t_us=sample.motion_t_us[::-1]), CONFIG, [])
