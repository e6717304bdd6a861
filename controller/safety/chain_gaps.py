"""The nearest capsules of each chain to each link."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from controller.safety.core_gaps import CORE_GAP, NO_LINK, CoreGaps
from controller.safety.gap import MM, TOUCHING_MM, Core, overlap
from controller.safety.link_cores import LinkCores
from controller.safety.segment_gap import segment_gaps
from controller.safety.surroundings import CapsuleChain

ALONGSIDE_M = 0.001  # assumed: a capsule hardly farther than the nearest of its chain counts too


def chain_gaps(links: LinkCores, chains: Sequence[CapsuleChain], within_m: float) -> CoreGaps:
    """Of each link and chain that are nearer than this: the nearest capsule and those alongside.

    `obstacle` counts the chains.
    """
    start_m, end_m, radius_m = (
        np.concatenate([getattr(chain, field) for chain in chains])
        for field in ("start_m", "end_m", "radius_m")
    )
    lengths = [len(chain.radius_m) for chain in chains]
    chain = np.repeat(np.arange(len(chains)), lengths)
    radii_m = links.radius_m[:, None] + radius_m
    apart_m, on_link, on_chain = segment_gaps(links, start_m, end_m, within_m + radii_m)
    for k, capsule in np.argwhere(apart_m <= TOUCHING_MM / MM).tolist():
        ends_m = np.stack([start_m[capsule], end_m[capsule]])
        found = overlap(links.core(k), Core(MM * ends_m))
        apart_m[k, capsule] = found.distance_mm / MM
        on_link[k, capsule], on_chain[k, capsule] = found.a_mm / MM, found.b_mm / MM
    distance_m = apart_m - radii_m
    nearest_m = np.minimum.reduceat(distance_m, np.cumsum([0, *lengths[:-1]]), axis=1)
    limit_m = np.minimum(nearest_m + ALONGSIDE_M, within_m)
    link, capsule = np.nonzero(distance_m < limit_m[:, chain])
    gaps = np.empty(len(link), CORE_GAP)
    gaps["link"], gaps["obstacle"], gaps["other_link"] = link, chain[capsule], NO_LINK
    gaps["apart_m"], gaps["other_radius_m"] = apart_m[link, capsule], radius_m[capsule]
    gaps["on_link_m"], gaps["on_other_m"] = on_link[link, capsule], on_chain[link, capsule]
    return gaps
