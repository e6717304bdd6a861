"""A storm: violent random motions of both tools, drawn from a seed, as no policy makes them.

A gust is one motion of an arm: walk, stab, bite, tear or chatter; or crush, by both arms together.
Gusts aim at the tissue's current position; the commanded tip moves at `MAX_SPEED_M_S` at most.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import zip_longest

import numpy as np

from controller.action import ToolAction
from controller.driver import Driver, rig_of
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.frames import AWAY, RIGHT, Array, exponential, rotation_to_6d, unit
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM, JointCommand
from tissue_sim.tools.instruments import right_tools
from tissue_sim.tools.psm import forward_kinematics
from tissue_sim.world import World

MAX_SPEED_M_S = 0.2
MAX_TURN_RAD_S = 3.0
CRUSH_SHARE = 0.2  # of the gusts
EXCHANGE_SHARE = 0.3  # of the pauses between gusts
WIDE_RAD, OPEN_RAD, SHUT_RAD = 1.2, 0.6, -0.3
CLOSING_STEPS = 6
HOLDING_STEPS = 4  # the jaws' lag
TEAR_M = (0.06, 0.10)
STAB_M = (0.005, 0.04)  # how far past the surface


@dataclass(frozen=True, kw_only=True)
class Motion:
    """Motion of one arm in one control step.

    Attributes:
        move_world_m: (3,) motion of the tip.
        turn_tool_rad: (3,) rotation vector.
        jaw_rad: Total opening to command.
    """

    move_world_m: Array = field(default_factory=lambda: np.zeros(3))
    turn_tool_rad: Array = field(default_factory=lambda: np.zeros(3))
    jaw_rad: float


@dataclass(frozen=True, kw_only=True)
class StormArm:
    """One arm, as a gust uses it."""

    row: int
    world: World
    driver: Driver
    rng: np.random.Generator

    @property
    def T_world_tool(self) -> Array:
        """Return the (4, 4) commanded pose."""
        arms, joints = self.world.arms, self.driver.joints[self.row]
        return arms.T_world_rcm[self.row] @ forward_kinematics(joints[:6], arms.mounted[self.row])

    def speed_m_s(self) -> float:
        """Draw a speed; about half of them are the highest allowed."""
        return float(min(MAX_SPEED_M_S, self.rng.uniform(0.02, 2 * MAX_SPEED_M_S)))

    def go(self, target_world_m: Array, jaw_rad: float) -> Iterator[Motion]:
        """Move in a straight line at a drawn, constant speed."""
        way = target_world_m - self.T_world_tool[:3, 3]
        steps = max(1, int(np.ceil(np.linalg.norm(way) / (self.speed_m_s() * CONTROL_PERIOD_S))))
        for _ in range(steps):
            yield Motion(move_world_m=way / steps, jaw_rad=jaw_rad)

    def stay(self, jaws_rad: Array) -> Iterator[Motion]:
        """Stay in place, with the jaws at one angle after another."""
        for jaw_rad in jaws_rad:
            yield Motion(jaw_rad=float(jaw_rad))


def storm(world: World, seed: int) -> Iterator[JointCommand]:
    """Yield joint targets for control steps, without end; exchange tools between gusts."""
    rng = np.random.default_rng(seed)
    driver = Driver(_rig(world), world.target)
    arms = [StormArm(row=row, world=world, driver=driver, rng=rng) for row in (LEFT_ARM, RIGHT_ARM)]
    while True:
        if rng.random() < EXCHANGE_SHARE:
            world.equip(str(rng.choice(right_tools())))
            driver.attach(_rig(world), driver.joints)
        if rng.random() < CRUSH_SHARE:
            point = a_point_of_tissue(world, rng)
            gusts = [crush(arm, point) for arm in arms]
        else:
            gusts = [GUSTS[rng.integers(len(GUSTS))](arm) for arm in arms]
        for motions in zip_longest(*gusts):
            yield driver.drive(_action(motions, driver.joints, world))


def a_point_of_tissue(world: World, rng: np.random.Generator) -> Array:
    """Draw a point (3,) on the current axis of a tube or the sac, with equal chance."""
    part = rng.choice([*world.organ.tubes, "sac"])
    sac = world.tissue.positions()[world.organ.sac_rings[:, 0]].astype(float)
    line = sac if part == "sac" else world.tubes.centres(part)
    return line[rng.integers(len(line))]


def walk(arm: StormArm) -> Iterator[Motion]:
    """Move tip and jaws smoothly and aimlessly."""
    velocity, spin, jaw = np.zeros(3), np.zeros(3), OPEN_RAD / 2
    for _ in range(arm.rng.integers(10, 40)):
        velocity = 0.8 * velocity + arm.rng.normal(0.0, 0.5 * MAX_SPEED_M_S, 3)
        spin = 0.8 * spin + arm.rng.normal(0.0, 0.5 * MAX_TURN_RAD_S, 3)
        jaw = float(np.clip(jaw + arm.rng.normal(0.0, 0.15), SHUT_RAD, 2 * OPEN_RAD))
        yield Motion(
            move_world_m=_at_most(velocity, MAX_SPEED_M_S) * CONTROL_PERIOD_S,
            turn_tool_rad=_at_most(spin, MAX_TURN_RAD_S) * CONTROL_PERIOD_S,
            jaw_rad=jaw,
        )


def stab(arm: StormArm) -> Iterator[Motion]:
    """Stab straight into the tissue, as far as the liver, and retract."""
    point = a_point_of_tissue(arm.world, arm.rng)
    start = arm.T_world_tool[:3, 3]
    jaw_rad = float(arm.rng.choice([SHUT_RAD, OPEN_RAD]))
    yield from arm.go(point + arm.rng.uniform(*STAB_M) * unit(point - start), jaw_rad)
    yield from arm.go(start, jaw_rad)


def bite(arm: StormArm) -> Iterator[Motion]:
    """Open over the tissue and close: a grasp, a clip or a cut."""
    point = a_point_of_tissue(arm.world, arm.rng)
    into = arm.T_world_tool[:3, 2]
    yield from arm.go(point + arm.rng.uniform(0.0, 0.01) * into, OPEN_RAD)
    yield from arm.stay(np.linspace(OPEN_RAD, SHUT_RAD, CLOSING_STEPS))


def tear(arm: StormArm) -> Iterator[Motion]:
    """Grasp firmly and pull away at a drawn speed, mostly towards the surgeon."""
    into = arm.T_world_tool[:3, 2]
    point = a_point_of_tissue(arm.world, arm.rng)
    yield from arm.go(point + arm.rng.uniform(0.004, 0.012) * into, WIDE_RAD)
    yield from arm.stay(np.linspace(WIDE_RAD, SHUT_RAD, CLOSING_STEPS))
    yield from arm.stay(np.full(HOLDING_STEPS, SHUT_RAD))
    direction = unit(unit(arm.rng.normal(size=3)) - AWAY)
    yield from arm.go(arm.T_world_tool[:3, 3] + arm.rng.uniform(*TEAR_M) * direction, SHUT_RAD)


def chatter(arm: StormArm) -> Iterator[Motion]:
    """Set the jaws to a random angle in every control step, in the tissue."""
    yield from arm.go(a_point_of_tissue(arm.world, arm.rng), OPEN_RAD)
    yield from arm.stay(arm.rng.uniform(SHUT_RAD, 2 * OPEN_RAD, size=arm.rng.integers(5, 20)))


def crush(arm: StormArm, point_world_m: Array) -> Iterator[Motion]:
    """Move from this arm's side through the point, and close the jaws."""
    outward = RIGHT if arm.row == RIGHT_ARM else -RIGHT
    yield from arm.go(point_world_m + 0.015 * outward, OPEN_RAD)
    yield from arm.go(point_world_m - 0.005 * outward, OPEN_RAD)
    yield from arm.stay(np.linspace(OPEN_RAD, SHUT_RAD, CLOSING_STEPS))


GUSTS: tuple[Callable[[StormArm], Iterator[Motion]], ...] = (
    walk,
    stab,
    bite,
    tear,
    tear,
    tear,
    chatter,
)


def _action(motions: tuple[Motion | None, ...], joints: Array, world: World) -> ToolAction:
    """Combine both arms' motions into one action; an arm whose gust has ended stays."""
    at_rest = [
        m or Motion(jaw_rad=jaw_rad) for m, jaw_rad in zip(motions, joints[:, 6], strict=True)
    ]
    return ToolAction(
        move_endoscope_m=np.stack([m.move_world_m for m in at_rest])
        @ world.T_world_endoscope[:3, :3],
        turn_tool=np.stack([rotation_to_6d(exponential(m.turn_tool_rad)) for m in at_rest]),
        jaw_rad=np.array([m.jaw_rad for m in at_rest]),
    )


def _at_most(vector: Array, length: float) -> Array:
    return vector * min(1.0, length / max(float(np.linalg.norm(vector)), 1e-12))


def _rig(world: World):
    return rig_of(world.arms.T_world_rcm, world.T_world_endoscope, world.arms.mounted)
