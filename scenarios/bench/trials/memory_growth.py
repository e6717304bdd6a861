"""Measure whether resets leak: the process's memory over many resets."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from tissue_sim.patient.anatomy import anatomy_from_seed
from tissue_sim.world import World

WARM_UP = 0.2  # share of the resets that fill caches
PATIENTS = 20  # in turn, so that the largest comes in the warm-up


def growth_kb_a_reset(reset: Callable[[int], object], resets: int, seed: int) -> float:
    """Return the least-squares slope of the resident memory after the warm-up, KB a reset."""
    sizes = np.array(list(_sizes_kb(reset, resets, seed)))
    after = np.arange(resets) >= WARM_UP * resets
    return float(np.polyfit(np.flatnonzero(after), sizes[after], 1)[0])


def world_resetter() -> Callable[[int], object]:
    """Return a function that resets one world."""
    world = World()
    return lambda seed: world.reset(anatomy_from_seed(seed))


def environment_resetter() -> Callable[[int], object]:
    """Return a function that resets one ManiSkill environment, which rebuilds its scene."""
    from tissue_sim.environment import make_single

    env = make_single(obs_mode="state")
    return lambda seed: env.reset(seed=seed)


def _sizes_kb(reset: Callable[[int], object], resets: int, seed: int) -> Iterator[float]:
    for k in range(resets):
        reset(seed + k % PATIENTS)
        yield resident_kb()


def resident_kb() -> float:
    """Return the resident memory of this process, KB."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1024
