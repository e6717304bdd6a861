"""Represent the operating field: everything on the table, as the simulator knows it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tissue_sim.frames import Array, transform
from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.patient.body import Body
from tissue_sim.patient.organ import Organ
from tissue_sim.patient.sac import Sac
from tissue_sim.patient.tubes import Tubes
from tissue_sim.surgery.clip import Clip, T_world_clip
from tissue_sim.surgery.record import Conditions, Record
from tissue_sim.tools.arms import Arms


@dataclass(kw_only=True, eq=False, repr=False)
class Field:
    """One patient's tissue, the two arms, and the history. `World` adds time.

    Attributes:
        arms: Both instrument arms, as rigid bodies.
        anatomy: The patient.
        organ: The patient's tissue at rest, as a mesh.
        tissue: The same tissue in its current deformed and cut state.
        tubes: Duct and arteries in `tissue`.
        sac: The gallbladder's wall in `tissue`.
        body: The liver and the fixed ends, to which the organ is attached. The body moves with the
            breath.
        T_world_endoscope: (4, 4) pose of the endoscope.
        conditions: Grip of the jaws, dye on the tissue.
        wrenches: Force (8, 3), N, and moment (8, 3), N m, of the tissue on the arms' links.
        record: The history so far.
    """

    arms: Arms
    anatomy: Anatomy
    organ: Organ
    tissue: Tissue
    tubes: Tubes
    sac: Sac
    body: Body
    T_world_endoscope: Array
    conditions: Conditions
    wrenches: tuple[NDArray[np.floating], NDArray[np.floating]]
    record: Record

    def clip_position_m(self, clip: Clip) -> Array:
        """Return the middle of a clip (3,), world frame.

        It is the middle of the tubes in the clip, or of the clip's legs if it is on no tube. The
        middle of the clipped tissue vertices would be up to 0.4 mm away.
        """
        T = T_world_clip(self.tubes, clip)
        if not clip.vertices:
            return T[:3, 3] - 0.5 * clip.kind.length_m * T[:3, 2]
        return transform(T, np.mean([c.point_m for c in clip.crossings], axis=0))

    def tool_forces_n(self) -> Array:
        """Return the force of the tissue on each instrument (2, 3), world frame, N."""
        return self.wrenches[0].reshape(2, 4, 3).sum(axis=1).astype(float)

    def bed_press_n(self) -> float:
        """Return the force between gallbladder and liver bed, N."""
        return float(np.linalg.norm(self.tissue.host("bed_force")[0]))
