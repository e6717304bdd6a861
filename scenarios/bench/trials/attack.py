"""Adversarial commands: what a policy that has gone wrong might ask of the arms.

An attack asks, control step by control step, for joints (2, 7), given those commanded last. It
keeps asking, whatever became of its last wish.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from controller.links import tool_jacobian
from controller.safety.limits.joint_speed import JOINT_SPEED
from controller.safety.obstacles import (
    COMMON_DUCT,
    LIVER,
    PORT_WALL,
    RigidSurroundings,
    Surroundings,
)
from tissue_sim.frames import Array, unit
from tissue_sim.periods import CONTROL_PERIOD_S
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM
from tissue_sim.tools.instruments import Instrument
from tissue_sim.tools.psm import INSERTION_AT_RCM_M, forward_kinematics, joint_limits

ARMS = (LEFT_ARM, RIGHT_ARM)
SPEED_M_S = (0.05, 1.5)  # of straight attacks: some the filter may let pass, some it may not
BEYOND = 0.3  # of a joint's range is asked for on either side of it
HASTE = 3.0  # times the speed of a joint
START = np.array(  # about home, from where every keep-out is within reach
    [(-0.5, 0.5), (-0.4, 0.4), (0.05, 0.15), (-2.0, 2.0), (-1.1, 1.1), (-1.1, 1.1), (0.0, 0.7)]
)

Attack = Callable[[Array], Array]


@dataclass(frozen=True, kw_only=True)
class AttackTargets:
    """What an attack may aim at.

    Attributes:
        T_world_rcm: (2, 4, 4).
        instruments: on the left and right arm.
        points_m: name -> (n, 3) points of what must not be hit, world frame.
    """

    T_world_rcm: Array
    instruments: tuple[Instrument, Instrument]
    points_m: dict[str, Array]

    @property
    def joint_ranges(self) -> Array:
        """(2, 7, 2), the jaw last."""
        return np.stack([np.vstack([joint_limits(i), i.jaw_range_rad]) for i in self.instruments])

    def tip_m(self, arm: int, joints: Array) -> Array:
        """(3,) at one arm's joints (7,), world frame."""
        T = self.T_world_rcm[arm] @ forward_kinematics(joints[:6], self.instruments[arm])
        return T[:3, 3]

    def straight(self, arm: int, joints: Array, move_m: Array) -> Array:
        """(7,) change of joints that moves the tip by `move_m` (3,), world frame; first order."""
        J = tool_jacobian(joints[:6], self.instruments[arm])[:3]
        return np.append(np.linalg.pinv(J) @ self.T_world_rcm[arm, :3, :3].T @ move_m, 0.0)


def aims(rigid: RigidSurroundings, around: Surroundings) -> dict[str, Array]:
    """Points (n, 3) of each keep-out that does not move by itself."""
    round_ones = around.capsules
    tubes = [name for name in round_ones.names if name == "duct" or "artery" in name]
    return {
        LIVER: rigid.liver.points_m + around.moved_m[LIVER],
        PORT_WALL: rigid.port_wall.points_m,
        COMMON_DUCT: round_ones.start_m[round_ones.of(COMMON_DUCT)],
        "tubes": np.concatenate([round_ones.start_m[round_ones.of(name)] for name in tubes]),
    }


def random_start(rng: np.random.Generator) -> Array:
    """(2, 7) joints from which an attack may begin."""
    return rng.uniform(*START.T, size=(2, 7))


def restless(field: AttackTargets, start: Array, rng: np.random.Generator) -> Attack:
    """Smooth and aimless motions of all joints, up to several times as fast as they may be."""
    rate = np.zeros((2, 7))

    def ask(joints: Array) -> Array:
        rate[:] = 0.8 * rate + rng.normal(size=(2, 7)) * JOINT_SPEED
        return joints + CONTROL_PERIOD_S * rate

    return ask


def straight_at(name: str) -> Callable[[AttackTargets, Array, np.random.Generator], Attack]:
    """Both tips, in straight lines through a point of something."""

    def attack(field: AttackTargets, start: Array, rng: np.random.Generator) -> Attack:
        return _through(field, start, rng.choice(field.points_m[name], 2), rng)

    return attack


def at_the_other_arm(field: AttackTargets, start: Array, rng: np.random.Generator) -> Attack:
    """Each tip in a straight line at a point of the other arm's shaft or tool."""
    ports, tips = field.T_world_rcm[:, :3, 3], [field.tip_m(arm, start[arm]) for arm in ARMS]
    on_shafts = [
        p + s * (t - p) for p, t, s in zip(ports, tips, rng.uniform(0.3, 1.0, 2), strict=True)
    ]
    return _through(field, start, np.stack(on_shafts[::-1]), rng)


def at_joint_limits(field: AttackTargets, start: Array, rng: np.random.Generator) -> Attack:
    """Every joint towards, and beyond, one of its limits."""
    lower, upper = np.moveaxis(field.joint_ranges, -1, 0)
    goal = np.where(rng.random((2, 7)) < 0.5, lower, upper)
    goal += np.sign(goal - 0.5 * (lower + upper)) * BEYOND * (upper - lower)
    most = CONTROL_PERIOD_S * HASTE * rng.uniform(0.1, 1.0) * JOINT_SPEED
    return lambda joints: joints + np.clip(goal - joints, -most, most)


def jumps(field: AttackTargets, start: Array, rng: np.random.Generator) -> Attack:
    """In every step to some other place of the whole joint range."""
    lower, upper = np.moveaxis(field.joint_ranges, -1, 0)
    lower[:, 2] = np.maximum(lower[:, 2], INSERTION_AT_RCM_M)
    return lambda joints: rng.uniform(lower, upper)


def jaw_snaps(field: AttackTargets, start: Array, rng: np.random.Generator) -> Attack:
    """Slowly to the tubes, the jaws as wide and as closed as may be by turns."""
    slowly = straight_at("tubes")(field, start, rng)
    wide, closed = field.joint_ranges[:, 6, 1], field.joint_ranges[:, 6, 0]

    def ask(joints: Array) -> Array:
        asked = slowly(joints)
        asked[:, 6] = np.where(rng.random(2) < 0.5, wide, closed)
        return asked

    return ask


ATTACKS: dict[str, Callable[[AttackTargets, Array, np.random.Generator], Attack]] = {
    "restless": restless,
    "at the liver": straight_at(LIVER),
    "at the other arm": at_the_other_arm,
    "at the common bile duct": straight_at(COMMON_DUCT),
    "at the tubes": straight_at("tubes"),
    "at the port wall": straight_at(PORT_WALL),
    "at joint limits": at_joint_limits,
    "jumps": jumps,
    "jaw snaps": jaw_snaps,
}


def _through(
    field: AttackTargets, start: Array, points_m: Array, rng: np.random.Generator
) -> Attack:
    """Each tip in a straight line through its point (2, 3), at a drawn, steady speed."""
    tips = np.stack([field.tip_m(arm, start[arm]) for arm in ARMS])
    speed_m_s = np.exp(rng.uniform(*np.log(SPEED_M_S), size=(2, 1)))
    moves_m = CONTROL_PERIOD_S * speed_m_s * unit(points_m - tips)
    return lambda joints: (
        joints + np.stack([field.straight(a, joints[a], moves_m[a]) for a in ARMS])
    )
