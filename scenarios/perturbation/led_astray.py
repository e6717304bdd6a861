"""SRT-H's recovery set: an arm is led to a wrong pose, then given back to the controller.

Nothing irreversible happens: no clip is set and nothing is cut.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from controller.action import ToolAction, hold
from controller.expert.motion import JAW_SPEED_RAD_S, before, between, minimum_jerk
from controller.expert.skills import GRASP_PINCH_N, GRASP_SHUT_RAD
from controller.expert.targets import (
    CLEARANCE_M,
    GRASP_OPEN_RAD,
    applier_at_work,
    astride,
    clip_pose,
    grasp_pose,
    opening_rad,
)
from planner.procedure.cholecystectomy import TASKS
from planner.procedure.outcomes import structure_of
from planner.procedure.task import Task
from scenarios.perturbation.effect import Effect
from scenarios.perturbation.perturbation import Perturbation
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.frames import Array, rotation_to_6d, unit
from tissue_sim.patient.organ import TUBES
from tissue_sim.surgery.abuses import crushed
from tissue_sim.surgery.grasp import LEFT_FINGERS, pinch_n
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM
from tissue_sim.tools.instruments import Instrument
from tissue_sim.tools.psm import forward_kinematics

if TYPE_CHECKING:
    from tissue_sim.world import World

# Assumed, all of them.
NEAR_M = 0.022  # tip's distance from its goal at which the tool is about to act
GRASPER_ROOM_M = 0.010  # along the tubes from wide open jaws to the grasper's tip
BOTH_BEYOND_M = 0.003  # the tips past both tubes: jaws are widest at the tips
CAUGHT_N = 0.1  # pinch on a tube at which jaws stop; 2.5 N crush it
SHUTTING_RAD = 0.012  # in a control step: slow enough to stop at a thin tube
STANDOFF_M = 0.015  # before the wrong pose: it is approached from there, to avoid other tissue

Waypoint = tuple[Array, float]  # T_world_tool (4, 4) and jaw opening (rad)


class LedAstray(Effect, ABC):
    """Takes over an arm that is about to act in a task, moves it smoothly, and gives it back."""

    arm: ClassVar[int] = RIGHT_ARM

    def __init__(self, perturbation: Perturbation, rng: np.random.Generator) -> None:
        super().__init__(perturbation, rng)
        self._path: Iterator[Waypoint] | None = None

    def lead(self, world: World, task: Task) -> ToolAction | None:
        if self._path is None and self.due(world, task) and self._about_to_act(world, task):
            self._path = self._leading(world, *self.failing(world, task))
            self.note(world.record.time_s)
        if self._path is None:
            return None
        if (waypoint := next(self._path, None)) is None:
            self._path = iter(())  # can be copied; a generator cannot
            return None
        return _action(world, self.arm, *waypoint)

    def goal(self, world: World, task: Task) -> Array:
        """Return `T_world_tool` at the task's goal; by default the clip's place."""
        return clip_pose(world, structure_of(task, world), task.clip or 1)

    @abstractmethod
    def failing(self, world: World, task: Task) -> Waypoint:
        """Return the wrong pose, and the jaw opening in it."""

    def _about_to_act(self, world: World, task: Task) -> bool:
        tip, goal = commanded_pose(world, self.arm)[:3, 3], self.goal(world, task)[:3, 3]
        return bool(np.linalg.norm(tip - goal) < NEAR_M)

    def _leading(self, world: World, T_failing: Array, jaw_rad: float) -> Iterator[Waypoint]:
        jaw = float(world.target[self.arm, 6])
        for T_end in (before(T_failing, STANDOFF_M), T_failing):
            for T in minimum_jerk(commanded_pose(world, self.arm), T_end):
                jaw = _nearer(jaw, jaw_rad)
                yield T, jaw


class GraspMissed(LedAstray):
    """Closes the grasper `magnitude` m off the infundibulum, along the image's vertical."""

    arm = LEFT_ARM
    tasks = tuple(task.index for task in TASKS if task.grasps)
    side: ClassVar[float]

    def goal(self, world: World, task: Task) -> Array:
        return grasp_pose(world)

    def failing(self, world: World, task: Task) -> Waypoint:
        T = grasp_pose(world)
        T[:3, 3] += self.side * self.magnitude * world.T_world_endoscope[:3, 1]
        return T, GRASP_OPEN_RAD

    def _leading(self, world: World, T_failing: Array, jaw_rad: float) -> Iterator[Waypoint]:
        yield from super()._leading(world, T_failing, jaw_rad)
        while jaw_rad > GRASP_SHUT_RAD and not _has_hold(world):
            jaw_rad = max(jaw_rad - SHUTTING_RAD, GRASP_SHUT_RAD)
            yield T_failing, jaw_rad


class GraspMissedAbove(GraspMissed):
    side = 1.0


class GraspMissedBelow(GraspMissed):
    side = -1.0


class ApplierAstray(LedAstray):
    """Leads the clip applier astray before a clip, while both tubes are uncut."""

    tasks = tuple(t.index for t in TASKS if t.places_clip and t.tube == "left")

    def failing(self, world: World, task: Task) -> Waypoint:
        tube = structure_of(task, world)
        opening = opening_rad(world.tubes, tube, applier_at_work(world, tube).name)
        T, jaw = self.worst(world, task, tube)
        share = self.magnitude
        return between(self.goal(world, task), T, share), opening + share * (jaw - opening)

    @abstractmethod
    def worst(self, world: World, task: Task, tube: str) -> Waypoint:
        """Return the pose and jaw opening for a magnitude of 1."""


class WrongTube(ApplierAstray):
    """Puts the open jaws around the other tube; the magnitude is the share of the path there."""

    def worst(self, world: World, task: Task, tube: str) -> Waypoint:
        other = _other(tube)
        applier = applier_at_work(world, other).name
        opening = opening_rad(world.tubes, other, applier)
        return clip_pose(world, other, task.clip or 1), opening


class BothTubes(ApplierAstray):
    """Puts wide open jaws around both tubes where they are nearest; magnitude: share of the path.

    The jaws keep clear of the grasper; they cannot reach around tubes that are far apart.
    """

    def worst(self, world: World, task: Task, tube: str) -> Waypoint:
        T, tubes = self.goal(world, task), world.tubes
        here, there = _nearest(tubes.centres(tube), tubes.centres(_other(tube)))
        across = unit(there - here)
        across = across * np.sign(across @ T[:3, 1])
        along = unit(np.cross(across, T[:3, 2]))
        wide_m = 0.5 * float(np.linalg.norm(there - here)) + max(map(tubes.radius_m, TUBES))
        middle = 0.5 * (here + there)
        room_m = (commanded_pose(world, LEFT_ARM)[:3, 3] - middle) @ along
        middle = middle - max(GRASPER_ROOM_M - room_m, 0.0) * along
        T_both = astride(middle, along, T[:3, 2], beyond_m=BOTH_BEYOND_M)
        applier = applier_at_work(world, tube)
        return T_both, _opening_rad(applier, wide_m + CLEARANCE_M, BOTH_BEYOND_M)


class Overshoot(LedAstray):
    """Pushes the open applier `magnitude` m too far past the tube.

    The first clip of a tube is exempt: there the filter stops the applier at the structure at risk
    behind.
    """

    tasks = tuple(task.index for task in TASKS if task.places_clip and task.clip != 1)

    def failing(self, world: World, task: Task) -> Waypoint:
        T = before(self.goal(world, task), -self.magnitude)
        tube = structure_of(task, world)
        return T, opening_rad(world.tubes, tube, applier_at_work(world, tube).name)


def commanded_pose(world: World, arm: int) -> Array:
    """Return an arm's commanded `T_world_tool` (4, 4)."""
    T_rcm_tool = forward_kinematics(world.target[arm, :6], world.arms.mounted[arm])
    return world.arms.T_world_rcm[arm] @ T_rcm_tool


def _action(world: World, arm: int, T_world_tool: Array, jaw_rad: float) -> ToolAction:
    """Return the action from the arm's commanded pose to a pose; the other arm holds."""
    T, still = commanded_pose(world, arm), hold(world.target[:, 6])
    moves, turns, jaws = still.move_endoscope_m.copy(), still.turn_tool.copy(), still.jaw_rad.copy()
    moves[arm] = (T_world_tool[:3, 3] - T[:3, 3]) @ world.T_world_endoscope[:3, :3]
    turns[arm] = rotation_to_6d(T[:3, :3].T @ T_world_tool[:3, :3])
    jaws[arm] = jaw_rad
    return ToolAction(move_endoscope_m=moves, turn_tool=turns, jaw_rad=jaws)


def _has_hold(world: World) -> bool:
    """Return whether the grasper pinches firmly, or has caught a tube; it must not crush a tube."""
    caught_n = max(reading.value for reading in crushed(world, world.record))
    return _pinch_n(world) >= GRASP_PINCH_N or caught_n > CAUGHT_N


def _pinch_n(world: World) -> float:
    """Return the grasper's pinch force on any tissue, not only on the infundibulum."""
    everything = np.arange(world.tissue.n_vertex(), dtype=np.int32)
    return pinch_n(world.tissue, everything, LEFT_FINGERS, world.arms.T_world_tool()[LEFT_ARM])


def _nearer(jaw_rad: float, goal_rad: float) -> float:
    most = JAW_SPEED_RAD_S * CONTROL_PERIOD_S
    return jaw_rad + float(np.clip(goal_rad - jaw_rad, -most, most))


def _nearest(a_m: Array, b_m: Array) -> tuple[Array, Array]:
    """Return the nearest points (3,) of two lines (n, 3)."""
    apart = np.linalg.norm(a_m[:, None] - b_m[None], axis=-1)
    i, j = np.unravel_index(np.argmin(apart), apart.shape)
    return a_m[i], b_m[j]


def _opening_rad(applier: Instrument, half_gap_m: float, behind_tip_m: float) -> float:
    """Return the applier's opening for a half gap behind the tips, or its widest opening."""
    sine = half_gap_m / (applier.yaw_to_tip_m - behind_tip_m)
    return min(2.0 * float(np.arcsin(min(sine, 1.0))), applier.jaw_range_rad[1])


def _other(tube: str) -> str:
    return "artery" if tube == "duct" else "duct"
