"""Tests of a clip on a structure at risk, where the cystic tube branches off."""

import numpy as np
import pytest

from tests.tissue_sim.patients import run, settled
from tissue_sim.frames import axis_angle
from tissue_sim.patient.at_risk import BRANCHES, COMMON_DUCT, HEPATIC_ARTERY
from tissue_sim.patient.organ import PARTS
from tissue_sim.structures.tubes import Tubes
from tissue_sim.surgery.clip import CLIP_LENGTH_M, Clip, latch
from tissue_sim.verification.bodies import astride


def clip_on_root(tubes: Tubes, trunk: str, roll_rad: float) -> Clip:
    """Close a clip square across the trunk at its branch, from a side of the trunk."""
    root = tubes.centres(BRANCHES[trunk])[0]
    ring = int(np.argmin(np.linalg.norm(tubes.centres(trunk) - root, axis=1)))
    station = tubes.stations_m[trunk][ring]
    T = astride(tubes, trunk, station, beyond_m=CLIP_LENGTH_M / 2)
    middle, _ = tubes.point(trunk, station)
    roll = axis_angle(T[:3, 0], roll_rad)
    T[:3] = np.column_stack([roll @ T[:3, :3], middle + roll @ (T[:3, 3] - middle)])
    return latch(tubes, T, number=1, time_s=0.0)


@pytest.mark.parametrize(
    ("seed", "trunk", "roll_rad"),
    [
        (0, COMMON_DUCT, -0.35),
        (0, COMMON_DUCT, -0.7),
        (3, COMMON_DUCT, -0.35),
        (3, HEPATIC_ARTERY, 0.7),
    ],
)
def test_a_clip_that_crushes_a_trunk_does_not_fold_the_root_of_its_branch(
    seed: int, trunk: str, roll_rad: float
) -> None:
    tubes = settled(seed)
    clip = clip_on_root(tubes, trunk, roll_rad)
    assert [crossing.tube for crossing in clip.crossings] == [trunk]
    run(tubes, 60)
    of_branch = tubes.organ.region // 2 == PARTS.index(BRANCHES[trunk])
    assert tubes.tissue.volumes()[of_branch].min() > 0.0
