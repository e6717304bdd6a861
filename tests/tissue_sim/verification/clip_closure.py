"""Verify a clip's squeeze: a block between springs in closed form, and a real tube's lumen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tests.tissue_sim.kinds import POLYMER
from tests.tissue_sim.verification.bodies import astride, box, face_share, overdamped, settle
from tissue_sim.frames import Array
from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.patient.material import Material
from tissue_sim.patient.organ import build_organ
from tissue_sim.patient.tubes import Tubes
from tissue_sim.surgery.clip import closure, grip_n, latch

BLOCK_M = (0.003, 0.003, 0.002)
SOFT = Material(young_pa=50e3, poisson=0.0)
SQUEEZED_TO = 0.3  # springs' length at rest over the block's height
SETTLE_STEPS, SQUEEZE_STEPS = 45, 60


@dataclass(frozen=True, kw_only=True)
class SqueezedBlock:
    """A block between springs that join its upper and lower side.

    Attributes:
        stiffness: (n,), total stiffness of the springs over the block's E A / H.
        height: (n,), height over the height at rest.
        expected: (n,), (k c + 1) / (k + 1) with k the stiffness and c = `SQUEEZED_TO`: two springs
            in series. The formula is exact, because fixed-corotated tissue without lateral
            contraction is linear in its stretch.
    """

    stiffness: Array
    height: Array
    expected: Array


@dataclass(frozen=True, kw_only=True)
class Closure:
    """A tube's lumen under clips of different strengths.

    Attributes:
        squeeze: (n,), springs' stiffness over that of the world's clip.
        lumen: (n,), smallest area of the lumen under the clip over the area at rest.
        grip_n: (n,), force of the legs, N.
    """

    tube: str
    squeeze: Array
    lumen: Array
    grip_n: Array


def squeezed_block(stiffness: Sequence[float]) -> SqueezedBlock:
    """Squeeze a block with springs of each stiffness."""
    k = np.array(stiffness)
    return SqueezedBlock(
        stiffness=k,
        height=np.array([_height(value) for value in stiffness]),
        expected=(k * SQUEEZED_TO + 1) / (k + 1),
    )


def clip_closure(anatomy: Anatomy, tube: str, squeeze: Sequence[float]) -> Closure:
    """Latch a clip of each strength on the middle of a tube."""
    organ = build_organ(anatomy)
    tissue = Tissue([organ], stiffness_scale=[anatomy.stiffness_scale])
    for _ in range(SETTLE_STEPS):
        tissue.step()
    settled = tissue.state()
    held = []
    for share in squeeze:
        tissue.restore(settled)
        held.append(_latch_and_settle(Tubes(tissue, organ), tube, share))
    return Closure(
        tube=tube,
        squeeze=np.array(squeeze),
        lumen=np.array([lumen for lumen, _ in held]),
        grip_n=np.array([grip for _, grip in held]),
    )


def _latch_and_settle(tubes: Tubes, tube: str, share: float) -> tuple[float, float]:
    """Return lumen and grip under a clip with a share of the normal stiffness."""
    middle = 0.5 * tubes.length_m[tube]
    T_world_tool = astride(tubes, tube, middle, beyond_m=POLYMER.length_m / 2)
    clip = latch(tubes, T_world_tool, POLYMER, number=1, time_s=0.0)
    tubes.tissue.host("link_stiffness")[0, list(clip.links)] *= share
    for _ in range(SQUEEZE_STEPS):
        tubes.tissue.step()
    return closure(tubes, clip, tube), grip_n(tubes, clip)


def _height(stiffness: float) -> float:
    """Return the block's height at rest between springs, over its height without them."""
    height = BLOCK_M[2]
    rest, tets = box(BLOCK_M, (3, 3, 2))
    lower, upper = (np.flatnonzero(rest[:, 2] == z) for z in (0.0, height))
    tissue = overdamped(rest, tets, SOFT, fixed=rest[:, 2] == 0.0)
    tissue.add_links(
        0,
        np.stack([lower, upper], axis=1),
        rest_m=np.full(len(lower), SQUEEZED_TO * height),
        stiffness=stiffness * SOFT.young_pa * face_share(rest, tets, 2, height)[upper] / height,
        strength_n=1.0e9,
    )
    tissue.rewire(0)
    return float(settle(tissue)[upper, 2].mean() / height)
