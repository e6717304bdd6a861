"""Test of a clip on the common bile duct, where the cystic duct branches off."""

import numpy as np
import pytest

from tests.tissue_sim.kinds import POLYMER
from tests.tissue_sim.patients import run, settled
from tests.tissue_sim.verification.bodies import astride
from tissue_sim.frames import axis_angle
from tissue_sim.patient.at_risk import COMMON_DUCT
from tissue_sim.patient.organ import PARTS
from tissue_sim.patient.tubes import Tubes
from tissue_sim.surgery.clip import Clip, latch

SEED = 5  # held by all of its vertices, or by all outer ones, the duct's root folds in this patient


def clip_on_root(tubes: Tubes, roll_rad: float) -> Clip:
    """Close a clip square across the common bile duct at the duct's root, from a side."""
    root = tubes.centres("duct")[0]
    ring = int(np.argmin(np.linalg.norm(tubes.centres(COMMON_DUCT) - root, axis=1)))
    station = tubes.stations_m[COMMON_DUCT][ring]
    T = astride(tubes, COMMON_DUCT, station, beyond_m=POLYMER.length_m / 2)
    middle, _ = tubes.point(COMMON_DUCT, station)
    roll = axis_angle(T[:3, 0], roll_rad)
    T[:3] = np.column_stack([roll @ T[:3, :3], middle + roll @ (T[:3, 3] - middle)])
    return latch(tubes, T, POLYMER, number=1, time_s=0.0)


@pytest.mark.parametrize("roll_rad", [-0.5, -0.35, 0.35, 0.5])
def test_a_clip_that_crushes_the_trunk_does_not_fold_the_root_of_its_branch(
    roll_rad: float,
) -> None:
    tubes = settled(SEED)
    clip = clip_on_root(tubes, roll_rad)
    assert [crossing.tube for crossing in clip.crossings] == [COMMON_DUCT]
    run(tubes, 60)
    of_duct = tubes.organ.region // 2 == PARTS.index("duct")
    assert tubes.tissue.volumes()[of_duct].min() > 0.0
