"""The operating field: everything that lies on the table, as the simulator knows it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tissue_sim.frames import Array
from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.patient.organ import Organ
from tissue_sim.structures.body import Body
from tissue_sim.structures.sac import Sac
from tissue_sim.structures.tubes import Tubes
from tissue_sim.surgery.clip import CLIP_LENGTH_M, Clip
from tissue_sim.surgery.conditions import Conditions
from tissue_sim.surgery.record import Record
from tissue_sim.tools.arms import Arms


@dataclass(kw_only=True, eq=False, repr=False)
class Field:
    """One patient's tissue, the two arms, and what has happened. `World` adds time to it.

    Attributes:
        arms: both instrument arms, as rigid bodies.
        anatomy: the patient.
        organ: the patient's tissue at rest, as a mesh.
        tissue: the same tissue as it is deformed and cut now.
        tubes: duct and arteries in `tissue`.
        sac: the gallbladder's wall in `tissue`.
        body: what holds the organ: the liver and the fixed ends. It moves with the breath.
        T_world_endoscope: (4, 4).
        conditions: grip of the jaws, dye on the tissue.
        wrenches: force (8, 3), N, and moment (8, 3), N m, of the tissue on the arms' links.
        record: what has happened so far.
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
        """Return the middle of a clip (3,), world frame: of what it holds, else of its legs."""
        if not clip.vertices:
            return clip.T_world_clip[:3, 3] - 0.5 * CLIP_LENGTH_M * clip.T_world_clip[:3, 2]
        held = self.tissue.positions()[list(clip.vertices)]
        return np.add.reduce(held, axis=0, dtype=float) / len(held)

    def tool_forces_n(self) -> Array:
        """Return the force of the tissue on each instrument (2, 3), world frame, N."""
        return self.wrenches[0].reshape(2, 4, 3).sum(axis=1).astype(float)

    def bed_press_n(self) -> float:
        """Return the force between gallbladder and liver bed, N."""
        return float(np.linalg.norm(self.tissue.host("bed_force")[0]))
