"""Changes of a sample before it is stacked. Each takes a numpy Generator, so that a sample's draws depend on nothing else."""
import dataclasses

import numpy as np

_MOST_GYRO_ERROR_RAD_S = 0.012  # standard deviation: what a bias leaves that no standstill has shown yet
_LONGEST_US = 1_000_000  # a window's, in camera.toml
_DIM_CELLS = (4, 5)  # of the field of light, rows and columns


def flip_horizontal(sample):
    """The mirrored world: x -> width - 1 - x; v_x, omega_y, omega_z and the plumb-bob's p2 change their signs."""
    camera = sample.camera
    coefficients = camera.coefficients.copy()
    if camera.distortion == 1:
        coefficients[3] = -coefficients[3]
    return dataclasses.replace(
        sample,
        camera=dataclasses.replace(camera, cx=camera.width - 1 - camera.cx, coefficients=coefficients),
        x=(camera.width - 1 - sample.x).astype(np.uint16),
        velocity_m_s=sample.velocity_m_s * np.float32([-1, 1, 1]),
        rate_rad_s=sample.rate_rad_s * np.float32([1, -1, -1]),
        inverse_depth=sample.inverse_depth[:, ::-1], moving=sample.moving[:, ::-1])


def flip_vertical(sample):
    """y -> height - 1 - y; v_y, omega_x, omega_z and the plumb-bob's p1 change their signs."""
    camera = sample.camera
    coefficients = camera.coefficients.copy()
    if camera.distortion == 1:
        coefficients[2] = -coefficients[2]
    return dataclasses.replace(
        sample,
        camera=dataclasses.replace(camera, cy=camera.height - 1 - camera.cy, coefficients=coefficients),
        y=(camera.height - 1 - sample.y).astype(np.uint16),
        velocity_m_s=sample.velocity_m_s * np.float32([1, -1, 1]),
        rate_rad_s=sample.rate_rad_s * np.float32([-1, 1, -1]),
        inverse_depth=sample.inverse_depth[::-1], moving=sample.moving[::-1])


def noisy_motion(sample, share, delay_us, random):
    """Measured motion: off by up to `share` of its norm, alike for the whole window, and `delay_us` late.

    The mean speed is kept. With the parallax ladder a wrong speed scales the ladder's metric step and leaves every
    image and every index as they are: the network could not know, and would only learn to blur.
    """
    def norm(v):
        return float(np.linalg.norm(v, axis=1).mean())

    speed, turn = norm(sample.velocity_m_s), norm(sample.rate_rad_s)
    velocity = sample.velocity_m_s + share * speed / np.sqrt(3) * random.standard_normal(3)
    gyro = _MOST_GYRO_ERROR_RAD_S * random.random() * (share > 0)
    rate = sample.rate_rad_s + (share * turn / np.sqrt(3) + gyro) * random.standard_normal(3)
    if speed > 0:
        velocity *= speed / max(norm(velocity), 1e-9)
    return dataclasses.replace(sample, velocity_m_s=velocity.astype(np.float32), rate_rad_s=rate.astype(np.float32),
                               motion_t_us=(sample.motion_t_us + int(delay_us)).astype(np.int32))


def slow_down(sample, factor):
    """The same way at 1 / factor of the speed: all times are `factor` times as long. The light's noise is not: add_noise."""
    def longer(t_us):
        return np.rint(t_us * float(factor)).astype(np.int32)

    return dataclasses.replace(sample, window_us=int(round(sample.window_us * factor)), t_us=longer(sample.t_us),
                               motion_t_us=longer(sample.motion_t_us), velocity_m_s=sample.velocity_m_s / np.float32(factor),
                               rate_rad_s=sample.rate_rad_s / np.float32(factor))


def with_events(sample, t_us, x, y, polarity):
    """The sample with more events, in the order of time."""
    t_us = np.concatenate([sample.t_us, t_us.astype(np.int32)])
    order = np.argsort(t_us, kind="stable")
    return dataclasses.replace(
        sample, t_us=t_us[order], x=np.concatenate([sample.x, x.astype(np.uint16)])[order],
        y=np.concatenate([sample.y, y.astype(np.uint16)])[order],
        polarity=np.concatenate([sample.polarity, polarity.astype(np.uint8)])[order])


def add_noise(sample, rate_hz, random):
    """Background activity: each pixel fires by itself so often, on or off."""
    camera = sample.camera
    count = random.poisson(rate_hz * camera.width * camera.height * sample.window_us * 1e-6)
    return with_events(sample, random.integers(-sample.window_us, 1, count), random.integers(0, camera.width, count),
                       random.integers(0, camera.height, count), random.integers(0, 2, count))


def dim(sample, random):
    """Leaves out events where a smooth random field is low: a night's unlit places."""
    camera = sample.camera
    cells = random.uniform(-1.0, 2.5, _DIM_CELLS)
    rows, columns = (np.linspace(0, n - 1, size) for n, size in zip(_DIM_CELLS, (camera.height, camera.width)))
    field = np.stack([np.interp(columns, np.arange(_DIM_CELLS[1]), row) for row in cells])
    low = np.minimum(rows.astype(int), _DIM_CELLS[0] - 2)
    share = (rows - low)[sample.y]
    light = (1 - share) * field[low[sample.y], sample.x] + share * field[low[sample.y] + 1, sample.x]
    keep = random.random(sample.t_us.size) < np.clip(light, 0.02, 1)
    return dataclasses.replace(sample, t_us=sample.t_us[keep], x=sample.x[keep], y=sample.y[keep], polarity=sample.polarity[keep])


def drop_events(sample, share, random):
    """Leaves out this share of the events."""
    keep = random.random(sample.t_us.size) >= share
    return dataclasses.replace(sample, t_us=sample.t_us[keep], x=sample.x[keep], y=sample.y[keep],
                               polarity=sample.polarity[keep])


def add_hot_pixels(sample, share, random):
    """This share of the pixels fires by itself, at 20 to 1000 Hz."""
    camera = sample.camera
    count = int(share * camera.width * camera.height)
    if count == 0:
        return sample
    rates_hz = 20.0 * 50.0 ** random.random(count)
    events = random.poisson(rates_hz * sample.window_us * 1e-6)
    total = int(events.sum())
    return with_events(sample, random.integers(-sample.window_us, 1, total),
                       np.repeat(random.integers(0, camera.width, count), events),
                       np.repeat(random.integers(0, camera.height, count), events), np.ones(total))


def augment(sample, config, random, of_world):
    """(sample, crop as (x, y, width, height), factor of the ladder's span) after an AugmentConfig. `of_world`: the
    generator of what all windows of a world share; a mirrored camera is another camera, whose table of rays costs time.
    """
    if of_world.random() < config.flip_horizontal:
        sample = flip_horizontal(sample)
    if of_world.random() < config.flip_vertical:
        sample = flip_vertical(sample)
    if random.random() < config.slow:
        sample = slow_down(sample, max(_LONGEST_US / max(sample.window_us, 1), 1.0) ** random.random())
        sample = add_noise(sample, config.noise_hz * 0.02 ** random.random(), random)
    sample = noisy_motion(sample, config.velocity_noise * random.random(), 1000 * config.delay_ms * random.random(),
                          random)
    if random.random() < config.dim:
        sample = dim(sample, random)
    elif random.random() < 0.5:
        sample = drop_events(sample, config.event_drop * random.random(), random)
    if random.random() < 0.3:
        sample = add_hot_pixels(sample, config.hot_pixels * random.random(), random)
    crop = (0, 0, 0, 0)
    if config.crop:
        height, width = config.crop
        x = int(random.integers(0, max(sample.camera.width - width, 0) + 1))
        y = int(random.integers(0, max(sample.camera.height - height, 0) + 1))
        crop = (x, y, min(width, sample.camera.width), min(height, sample.camera.height))
    low, high = config.span
    return sample, crop, low + (high - low) * random.random()
