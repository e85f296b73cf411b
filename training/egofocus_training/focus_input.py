"""What the network is told of a window: sharpness of each hypothesis, normalised, and a few maps of context. No weights.

The library makes it, in integers (docs/integer_model.md, "The network's input"): `focus` u8 [D, maps, h/4, w/4] and
`context` u8 [channels, h/4, w/4], bytes 0..127 about 64 in the steps of units.py. Here is what it is asked for.
"""


def context_channels(config):
    """Channels of the context of an InputConfig."""
    return 2 + len(config.maps) + 3 + 1


def parse_maps(maps):
    """[(name, side of the support in cells)]"""
    pairs = [entry.split(":") for entry in maps]
    return [(name, int(side)) for name, side in pairs]


def thousandths(value):
    """The whole number of thousandths that `value` is; None where it is none."""
    nearest = round(value * 1000)
    return nearest if nearest / 1000 == value else None


def binding_maps(config):
    """The binding's `maps` of an InputConfig: maps and both floors."""
    return parse_maps(config.maps), thousandths(config.floor_events), thousandths(config.floor_noise)
