"""Compute the gaps between links and the capsules of chains."""

from __future__ import annotations

import numpy as np

from controller.safety.geometry.core_gaps import CORE_GAP, NO_LINK, CoreGaps
from controller.safety.geometry.gap import MM, TOUCHING_MM, Core, overlap
from controller.safety.geometry.link_cores import LinkCores
from controller.safety.geometry.segment_gap import segment_gaps
from controller.safety.obstacles import Capsules

ALONGSIDE_M = 0.001  # assumed: capsules hardly farther than the nearest one of a chain


def chain_gaps(links: LinkCores, chains: Capsules, within_m: float) -> CoreGaps:
    """Return the gaps of links and capsules nearer than `within_m`; `obstacle` counts chains."""
    radii_m = links.radius_m[:, None] + chains.radius_m
    apart_m, on_link, on_chain = segment_gaps(
        links, chains.start_m, chains.end_m, within_m + radii_m
    )
    touching = apart_m <= TOUCHING_MM / MM
    for k, capsule in np.argwhere(touching).tolist() if touching.any() else ():
        ends_m = np.stack([chains.start_m[capsule], chains.end_m[capsule]])
        found = overlap(links.core(k), Core(MM * ends_m))
        apart_m[k, capsule] = found.distance_mm / MM
        on_link[k, capsule], on_chain[k, capsule] = found.a_mm / MM, found.b_mm / MM
    distance_m = apart_m - radii_m
    nearest_m = np.minimum.reduceat(distance_m, chains.first, axis=1)
    pair = link, capsule = np.nonzero(distance_m < within_m)
    gaps = np.empty(len(link), CORE_GAP)
    gaps["link"], gaps["obstacle"], gaps["other_link"] = link, chains.chain[capsule], NO_LINK
    gaps["apart_m"], gaps["other_radius_m"] = apart_m[pair], chains.radius_m[capsule]
    gaps["on_link_m"], gaps["on_other_m"] = on_link[pair], on_chain[pair]
    gaps["foremost"] = distance_m[pair] < nearest_m[link, gaps["obstacle"]] + ALONGSIDE_M
    return gaps
