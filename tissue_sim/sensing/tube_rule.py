"""Apply the clip rule to batches of observed tubes, each with its structure and its applier."""

from __future__ import annotations

from collections.abc import Callable

import torch
from torch import Tensor

from tissue_sim.tools.instruments import Instrument, appliers, clip_of

Value = Tensor | float


def by_tube(is_duct: Tensor, radius_m: Tensor, value: Callable[[str, Instrument], Value]) -> Tensor:
    """Return a value of the rule for each tube of a batch, by its structure and its width.

    Args:
        is_duct: (B, ...) whether the tube is the duct; else it is an artery.
        radius_m: (B, ...) outer radii of the tubes.
        value: Function from structure and applier to a value that fits (B, ...).
    """
    smallest, *others = appliers()
    found = _by_structure(is_duct, value, others[-1])
    for applier in reversed((smallest, *others[:-1])):
        least, most = clip_of(applier).vessel_m
        fits = (2.0 * radius_m >= least) & (2.0 * radius_m <= most)
        found = torch.where(fits, _by_structure(is_duct, value, applier), found)
    return found


def _by_structure(
    is_duct: Tensor, value: Callable[[str, Instrument], Value], applier: Instrument
) -> Tensor:
    return torch.where(is_duct, value("duct", applier), value("artery", applier))
