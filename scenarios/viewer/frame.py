"""Immutable copies of the world's state, which the page draws."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import count
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from controller.action import ToolAction
from controller.safety.obstacles import RigidSurroundings, registered
from tissue_sim.frames import Array, transform
from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.patient.mesher import Indices
from tissue_sim.patient.organ import Organ
from tissue_sim.rendering.drawing import Surface
from tissue_sim.rendering.drawn_clips import T_world_legs
from tissue_sim.rendering.drawn_leaks import leak_surfaces
from tissue_sim.rendering.drawn_strands import holding
from tissue_sim.rendering.drawn_tissue import alive_tets
from tissue_sim.sensing.observation import Observation

if TYPE_CHECKING:
    from tissue_sim.world import World

_NUMBERS = count()


@dataclass(frozen=True, kw_only=True)
class Patient:
    """The constant properties of a patient, in the world frame.

    Attributes:
        number: Unique within the process.
        T_world_endoscope: (4, 4) initial pose of the endoscope.
        keep_outs: Bodies that the safety filter keeps the instruments away from.
    """

    number: int
    anatomy: Anatomy
    organ: Organ
    T_world_endoscope: Array
    keep_outs: RigidSurroundings


@dataclass(frozen=True, kw_only=True)
class Frame:
    """The world at one simulated time, in the world frame.

    Attributes:
        patient: The patient's number.
        time_s: Simulated time.
        positions_m: (n, 3) positions of the tissue's vertices.
        tets: (n_tet, 4) remaining tetrahedra.
        alive: (n_organ_tet,) whether each of the organ's tetrahedra remains.
        dyed: Share of the tissue that is covered by red liquid.
        tools: Names of the left and right instrument.
        T_world_link: (2, 4, 4, 4) links of each arm, in the order of `PATCH_LINKS`.
        T_world_tool: (2, 4, 4) instrument tips.
        jaw_rad: (2,) jaw openings of the last command.
        T_world_leg: (n, 4, 4) legs of the clips.
        leg_kinds: Name of the kind of clip of each leg.
        strands_m: (n, 2, 3) ends of the intact connective-tissue strands.
        leaks: Surfaces of leaking liquid, by structure.
        forces_n: (2, 3) force of the tissue on each instrument.
        ahead_m: (2, n, 3) path of each tip through the rest of the action chunk, current tip first.
        seen_m: (n, 3) observed points; none without a sense, as in a replay.
        seen_std_m: (n,) standard deviations of the observed points.
        seen_hidden: (n,) whether each observed point is hidden from all cameras.
        body_m: (3,) displacement of the body from its initial place.
        T_world_endoscope: (4, 4) current pose of the endoscope.
    """

    patient: int
    time_s: float
    positions_m: NDArray[np.float32]
    tets: Indices
    alive: NDArray[np.bool_]
    dyed: float
    tools: tuple[str, str]
    T_world_link: Array
    T_world_tool: Array
    jaw_rad: Array
    T_world_leg: Array
    leg_kinds: tuple[str, ...]
    strands_m: Array
    leaks: dict[str, Surface] = field(default_factory=dict)
    forces_n: Array
    ahead_m: Array
    seen_m: Array
    seen_std_m: Array
    seen_hidden: NDArray[np.bool_]
    body_m: Array
    T_world_endoscope: Array


def patient_of(world: World) -> Patient:
    """Return the world's patient, under a new number."""
    return Patient(
        number=next(_NUMBERS),
        anatomy=world.anatomy,
        organ=world.organ,
        T_world_endoscope=world.T_world_endoscope.copy(),
        keep_outs=registered(world),
    )


def frame_of(
    world: World,
    patient: Patient,
    ahead: Sequence[ToolAction] = (),
    before: Frame | None = None,
    observation: Observation | None = None,
) -> Frame:
    """Return a frame of the world's current state and the controller's planned motions.

    Args:
        world: The world to copy.
        patient: The world's patient.
        ahead: The next actions of the current chunk.
        before: An earlier frame; its `tets` are shared unless tetrahedra were cut since.
        observation: The robot's observation.
    """
    T_world_tool = world.arms.T_world_tool()
    alive = alive_tets(world)
    tets = world.tissue.tets()[alive]
    if (
        before is not None
        and before.patient == patient.number
        and np.array_equal(tets, before.tets)
    ):
        tets, alive = before.tets, before.alive
    left, right = world.arms.mounted
    clips = T_world_legs(world)
    there = np.zeros(0, bool) if observation is None else observation.there
    points = np.zeros((0, 3)) if observation is None else observation.points_m()[there]
    return Frame(
        patient=patient.number,
        time_s=world.record.time_s,
        positions_m=world.tissue.positions().astype(np.float32),
        tets=tets,
        alive=alive,
        dyed=world.conditions.dyed,
        tools=(left.name, right.name),
        T_world_link=world.tissue.T_world_links().reshape(2, 4, 4, 4).astype(float),
        T_world_tool=T_world_tool,
        jaw_rad=world.target[:, 6],
        T_world_leg=np.array([legs for _, legs in clips]).reshape(-1, 4, 4),
        leg_kinds=tuple(kind.name for kind, legs in clips for _ in legs),
        strands_m=world.tissue.positions()[holding(world)].astype(float),
        leaks=leak_surfaces(world),
        forces_n=world.tool_forces_n(),
        ahead_m=_path(T_world_tool, world.T_world_endoscope, ahead),
        seen_m=transform(world.T_world_endoscope, points),
        seen_std_m=np.zeros(0) if observation is None else observation.std_m[there],
        seen_hidden=np.zeros(0, bool) if observation is None else observation.hidden[there],
        body_m=world.body.offset_m.copy(),
        T_world_endoscope=world.T_world_endoscope.copy(),
    )


def _path(T_world_tool: Array, T_world_endoscope: Array, ahead: Sequence[ToolAction]) -> Array:
    """Return the (2, n, 3) tip positions along the planned motions, the current ones first."""
    moves = np.array([action.move_endoscope_m for action in ahead]).reshape(-1, 2, 3)
    steps = moves.transpose(1, 0, 2) @ T_world_endoscope[:3, :3].T
    start = T_world_tool[:, None, :3, 3]
    return np.concatenate([start, start + np.cumsum(steps, axis=1)], axis=1)
