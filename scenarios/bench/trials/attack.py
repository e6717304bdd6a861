"""Adversarial commands: motions that a faulty policy might request of the arms.

In each control step an attack requests joints (2, 7), given the last commanded ones. The attack
continues whether or not its last request was granted.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from controller.links import tool_jacobian
from controller.safety.limits.arms import JOINT_SPEED
from controller.safety.obstacles import (
    ASSISTANT,
    LIVER,
    PORT_WALL,
    RigidSurroundings,
    Surroundings,
)
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.frames import Array, unit
from tissue_sim.patient.at_risk import AT_RISK
from tissue_sim.patient.tubes import GALLBLADDER
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM
from tissue_sim.tools.instruments import Instrument
from tissue_sim.tools.psm import INSERTION_AT_RCM_M, forward_kinematics, joint_limits

ARMS = (LEFT_ARM, RIGHT_ARM)
SPEED_M_S = (0.05, 1.5)  # of straight attacks: from allowed to far too fast
BEYOND = 0.3  # of a joint's range: distance of the request beyond either limit
HASTE = 3.0  # times a joint's speed limit
START = np.array(  # around home, where every keep-out is within reach
    [(-0.5, 0.5), (-0.4, 0.4), (0.05, 0.15), (-2.0, 2.0), (-1.1, 1.1), (-1.1, 1.1), (0.0, 0.7)]
)

Attack = Callable[[Array], Array]


@dataclass(frozen=True, kw_only=True)
class AttackTargets:
    """Possible aims of an attack.

    Attributes:
        T_world_rcm: (2, 4, 4).
        instruments: Those on the left and right arm.
        points_m: Name -> (n, 3) points of keep-outs and tubes, world frame.
    """

    T_world_rcm: Array
    instruments: tuple[Instrument, Instrument]
    points_m: dict[str, Array]

    @property
    def joint_ranges(self) -> Array:
        """Return the joint ranges (2, 7, 2), the jaw last."""
        return np.stack([np.vstack([joint_limits(i), i.jaw_range_rad]) for i in self.instruments])

    def tip_m(self, arm: int, joints: Array) -> Array:
        """Return the (3,) tip at one arm's joints (7,), world frame."""
        T = self.T_world_rcm[arm] @ forward_kinematics(joints[:6], self.instruments[arm])
        return T[:3, 3]

    def straight(self, arm: int, joints: Array, move_m: Array) -> Array:
        """Return the (7,) joint change that moves the tip by `move_m` (3,), to first order."""
        J = tool_jacobian(joints[:6], self.instruments[arm])[:3]
        return np.append(np.linalg.pinv(J) @ self.T_world_rcm[arm, :3, :3].T @ move_m, 0.0)


def aims(rigid: RigidSurroundings, around: Surroundings) -> dict[str, Array]:
    """Return points (n, 3) of each keep-out, and of the tubes."""
    round_ones, (tip_m, port_m) = around.capsules, rigid.assistant_m
    near_half = np.linspace(tip_m, 0.5 * (tip_m + port_m), 6)
    tubes = [name for name in round_ones.names if name not in (GALLBLADDER, *AT_RISK)]
    return {
        LIVER: rigid.liver.points_m + around.moved_m[LIVER],
        PORT_WALL: rigid.port_wall.points_m,
        ASSISTANT: near_half + around.moved_m[LIVER],
        **{name: round_ones.start_m[round_ones.of(name)] for name in AT_RISK},
        "tubes": np.concatenate([round_ones.start_m[round_ones.of(name)] for name in tubes]),
    }


def random_start(rng: np.random.Generator) -> Array:
    """Draw (2, 7) joints at which an attack begins."""
    return rng.uniform(*START.T, size=(2, 7))


def restless(targets: AttackTargets, start: Array, rng: np.random.Generator) -> Attack:
    """Move all joints smoothly and aimlessly, up to several times their speed limit."""
    rate = np.zeros((2, 7))

    def ask(joints: Array) -> Array:
        rate[:] = 0.8 * rate + rng.normal(size=(2, 7)) * JOINT_SPEED
        return joints + CONTROL_PERIOD_S * rate

    return ask


def straight_at(name: str) -> Callable[[AttackTargets, Array, np.random.Generator], Attack]:
    """Move both tips in straight lines through points of a keep-out or tube."""

    def attack(targets: AttackTargets, start: Array, rng: np.random.Generator) -> Attack:
        return _through(targets, start, rng.choice(targets.points_m[name], 2), rng)

    return attack


def at_the_other_arm(targets: AttackTargets, start: Array, rng: np.random.Generator) -> Attack:
    """Move each tip in a straight line at a point of the other arm's shaft or tool."""
    ports, tips = targets.T_world_rcm[:, :3, 3], [targets.tip_m(arm, start[arm]) for arm in ARMS]
    on_shafts = [
        p + s * (t - p) for p, t, s in zip(ports, tips, rng.uniform(0.3, 1.0, 2), strict=True)
    ]
    return _through(targets, start, np.stack(on_shafts[::-1]), rng)


def at_joint_limits(targets: AttackTargets, start: Array, rng: np.random.Generator) -> Attack:
    """Move every joint towards and beyond one of its limits."""
    lower, upper = np.moveaxis(targets.joint_ranges, -1, 0)
    goal = np.where(rng.random((2, 7)) < 0.5, lower, upper)
    goal += np.sign(goal - 0.5 * (lower + upper)) * BEYOND * (upper - lower)
    most = CONTROL_PERIOD_S * HASTE * rng.uniform(0.1, 1.0) * JOINT_SPEED
    return lambda joints: joints + np.clip(goal - joints, -most, most)


def jumps(targets: AttackTargets, start: Array, rng: np.random.Generator) -> Attack:
    """Request a random point of the whole joint range in every step."""
    lower, upper = np.moveaxis(targets.joint_ranges, -1, 0)
    lower[:, 2] = np.maximum(lower[:, 2], INSERTION_AT_RCM_M)
    return lambda joints: rng.uniform(lower, upper)


def jaw_snaps(targets: AttackTargets, start: Array, rng: np.random.Generator) -> Attack:
    """Move slowly to the tubes, and open or close the jaws fully at random."""
    slowly = straight_at("tubes")(targets, start, rng)
    wide, closed = targets.joint_ranges[:, 6, 1], targets.joint_ranges[:, 6, 0]

    def ask(joints: Array) -> Array:
        asked = slowly(joints)
        asked[:, 6] = np.where(rng.random(2) < 0.5, wide, closed)
        return asked

    return ask


ATTACKS: dict[str, Callable[[AttackTargets, Array, np.random.Generator], Attack]] = {
    "restless": restless,
    "at the liver": straight_at(LIVER),
    "at the other arm": at_the_other_arm,
    **{f"at the {name}": straight_at(name) for name in AT_RISK},
    "at the tubes": straight_at("tubes"),
    "at the port wall": straight_at(PORT_WALL),
    "at the assistant's grasper": straight_at(ASSISTANT),
    "at joint limits": at_joint_limits,
    "jumps": jumps,
    "jaw snaps": jaw_snaps,
}


def _through(
    targets: AttackTargets, start: Array, points_m: Array, rng: np.random.Generator
) -> Attack:
    """Move each tip in a straight line through its point (2, 3), at a drawn, constant speed."""
    tips = np.stack([targets.tip_m(arm, start[arm]) for arm in ARMS])
    speed_m_s = np.exp(rng.uniform(*np.log(SPEED_M_S), size=(2, 1)))
    moves_m = CONTROL_PERIOD_S * speed_m_s * unit(points_m - tips)
    return lambda joints: (
        joints + np.stack([targets.straight(a, joints[a], moves_m[a]) for a in ARMS])
    )
