"""Joint vectors for tests, from fractions of each joint's range, for any instrument."""

import numpy as np
from hypothesis import strategies as st

from tissue_sim.tools.instruments import INSTRUMENTS
from tissue_sim.tools.psm import joint_limits

INSERTION = 2
instruments = st.sampled_from(list(INSTRUMENTS.values()))
unit_interval = st.tuples(*[st.floats(0.0, 1.0)] * 6).map(np.array)


def within_limits(fraction, instrument):
    """Return joints (..., 6) over the whole range."""
    lower, upper = joint_limits(instrument).T
    return lower + fraction * (upper - lower)


def inside_the_body(fraction, instrument):
    """Return joints (..., 6) with the wrist 5 mm or more past the remote centre."""
    lower, upper = joint_limits(instrument).T
    lower[INSERTION] = 0.0206
    return lower + fraction * (upper - lower)


def with_jaw(fraction, jaw_fraction, instrument):
    """Return joints (..., 7) over the whole range, with the jaw."""
    lower, upper = instrument.jaw_range_rad
    jaw = lower + np.asarray(jaw_fraction) * (upper - lower)
    return np.concatenate([within_limits(fraction, instrument), jaw[..., None]], axis=-1)
