"""A world in use: instruments that reach the tissue, a clip and a cut; comparison of states."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from tests.tissue_sim.kinds import POLYMER
from tests.tissue_sim.verification.bodies import astride
from tissue_sim.surgery.clip import latch
from tissue_sim.surgery.cut import BLADE_LENGTH_M, sever
from tissue_sim.tools.arms import RIGHT_ARM, JointCommand
from tissue_sim.world import World

TUBE = "duct"


def reach(k: int) -> JointCommand:
    """Move both instruments into the field, side by side, with working jaws: they touch tissue."""
    q = np.tile([0.09, 0.15, 0.10, 0.1, 0.0, 0.0, 0.4], (2, 1))
    q[RIGHT_ARM] = [-0.22, 0.0, 0.10, 0.0, 0.1, 0.0, 0.5]
    q[:, 2] += 0.0012 * min(k, 30)
    q[:, 6] *= np.cos(0.3 * k)
    return JointCommand(joints=q)


def everything(world: World) -> list[np.ndarray]:
    return [
        world.tissue.positions().copy(),
        world.tissue.host("velocity").copy(),
        world.arms.joints,
        world.arms.joint_velocities,
        world.tool_forces_n(),
    ]


def run(world: World, first: int, last: int) -> list[list[np.ndarray]]:
    path = []
    for k in range(first, last):
        world.step(reach(k))
        path.append(everything(world))
    return path


def assert_same(a: Any, b: Any) -> None:
    """Assert that two objects of any type are equal bit for bit."""
    if isinstance(a, dict):
        assert a.keys() == b.keys()
        for name in a:
            assert_same(a[name], b[name])
    elif isinstance(a, list | tuple):
        assert len(a) == len(b)
        for x, y in zip(a, b, strict=True):
            assert_same(x, y)
    elif isinstance(a, np.ndarray):
        np.testing.assert_array_equal(a, b)
    elif hasattr(a, "__dataclass_fields__"):
        assert type(a) is type(b)
        assert_same(vars(a), vars(b))
    else:
        assert a == b


def clip_and_cut(world: World, share: float = 0.47) -> None:
    """Put a clip and, above it, a cut into the tissue and the record, as the tools do."""
    length = world.tubes.length_m[TUBE]
    T = astride(world.tubes, TUBE, 0.3 * length, beyond_m=POLYMER.length_m / 2)
    clip = latch(
        world.tubes, T, POLYMER, number=len(world.record.clips) + 1, time_s=world.record.time_s
    )
    T = astride(world.tubes, TUBE, share * length, beyond_m=BLADE_LENGTH_M / 2)
    cuts = sever(world.tubes, T, time_s=world.record.time_s)
    assert clip.complete == (True,)
    assert cuts
    world.record = replace(
        world.record, clips=(*world.record.clips, clip), cuts=(*world.record.cuts, *cuts)
    )
