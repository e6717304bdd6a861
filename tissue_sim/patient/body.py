"""Model the body that holds the organ and moves it with the breath, and the assistant with it."""

from __future__ import annotations

from typing import cast

import numpy as np
import sapien
from numpy.typing import NDArray

from tissue_sim.frames import Array, pose
from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.patient.assistant import (
    SHAFT_RADIUS_M,
    T_world_shaft,
    assistant_of,
    shaft_length_m,
)
from tissue_sim.patient.organ import Organ
from tissue_sim.patient.supports import LiverBed
from tissue_sim.tools.arms import ASSISTANT, LIVER

LIVER_SIZE_M = (0.055, 0.008, 0.065)  # half sizes: across, through, along
LIVER_SOFT_M = (0.006, 0.010)  # assumed: soft depth and margin before a tool meets resistance


class Body:
    """The body: fixed ends, the liver and its bed, strands of bed and ligament, the assistant.

    Attributes:
        rigid: The rigid bodies that the arms may touch: the liver, and the assistant's grasper.
        offset_m: (3,) offset from the anatomical place, world frame.
        target_m: (3,) offset at the end of the next control step.
        velocity_m_s: (3,) velocity in the last control step.
    """

    def __init__(self, scene: sapien.Scene, tissue: Tissue, organ: Organ) -> None:
        self._tissue, self._bed = tissue, organ.bed
        self._strands_m = organ.vertices[organ.anchored]
        self.rigid = (_liver(scene, organ.bed), _assistant(scene, organ))
        self._poses = [entity.pose for entity in self.rigid]
        self.offset_m, self.target_m, self.velocity_m_s = np.zeros((3, 3))

    def begin_step(self, duration_s: float) -> bool:
        """Set a steady velocity from offset to target; return False if it is and was zero."""
        was_moving = self.velocity_m_s.any()
        self.velocity_m_s = (self.target_m - self.offset_m) / duration_s
        return bool(was_moving or self.velocity_m_s.any())

    def move_rigid(self, share: float) -> None:
        """Move the rigid bodies to a share of the step's motion, for the arms."""
        for entity, at in zip(self.rigid, self._poses, strict=True):
            _physics(entity).set_kinematic_target(_shifted(at, self._at(share)))

    def move_tissue(self, share: float) -> None:
        """Move the tissue that the body holds to a share of the step's motion."""
        self._place_tissue(self._at(share))

    def end_step(self) -> None:
        """Set the offset to the target."""
        self.offset_m = self.target_m

    def state(self) -> NDArray[np.float64]:
        """Return (3, 3) offset, target and velocity."""
        return np.stack([self.offset_m, self.target_m, self.velocity_m_s])

    def restore(self, state: NDArray[np.float64]) -> None:
        """Restore what `state` returned; restore the tissue's own state first."""
        self.offset_m, self.target_m, self.velocity_m_s = state.copy()
        for entity, at in zip(self.rigid, self._poses, strict=True):
            entity.set_pose(_shifted(at, self.offset_m))
        self._place_tissue(self.offset_m)

    def _at(self, share: float) -> Array:
        return self.offset_m + share * (self.target_m - self.offset_m)

    def _place_tissue(self, offset_m: Array) -> None:
        tissue, n_strand = self._tissue, len(self._strands_m)
        held = np.flatnonzero((tissue.host("fixed")[0] != 0) & (tissue.host("clamped")[0] == 0))
        tissue.host("position")[0, held] = tissue.host("rest")[0, held] + offset_m
        tissue.host("velocity")[0, held] = self.velocity_m_s
        tissue.host("anchor_point")[0, :n_strand] = self._strands_m + offset_m
        tissue.host("bed_point")[0] = self._bed.point_m + offset_m


def _shifted(at: sapien.Pose, offset_m: Array) -> sapien.Pose:
    return sapien.Pose((at.p + offset_m).tolist(), at.q)


def _physics(entity: sapien.Entity) -> sapien.physx.PhysxRigidDynamicComponent:
    return cast(
        sapien.physx.PhysxRigidDynamicComponent,
        entity.find_component_by_type(sapien.physx.PhysxRigidDynamicComponent),
    )


def _liver(scene: sapien.Scene, bed: LiverBed) -> sapien.Entity:
    """Build a slab behind the gallbladder."""
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=LIVER_SIZE_M)
    builder.set_initial_pose(sapien.Pose(_T_world_liver(bed)))
    return builder.build_kinematic(name=LIVER)


def _assistant(scene: sapien.Scene, organ: Organ) -> sapien.Entity:
    """Build the shaft of the assistant's grasper; the jaws are in the fundus."""
    assistant = assistant_of(organ)
    builder = scene.create_actor_builder()
    builder.add_capsule_collision(
        radius=SHAFT_RADIUS_M, half_length=0.5 * shaft_length_m(assistant)
    )
    builder.set_initial_pose(sapien.Pose(T_world_shaft(assistant)))
    return builder.build_kinematic(name=ASSISTANT)


def _T_world_liver(bed: LiverBed) -> Array:
    across = np.cross(bed.normal, bed.along)
    deep, inward = LIVER_SOFT_M
    middle = (bed.edge_m + inward + LIVER_SIZE_M[2]) * bed.along
    middle = middle - (deep + LIVER_SIZE_M[1]) * bed.normal
    return pose(np.stack([across, bed.normal, bed.along], axis=1), bed.point_m + middle)
