"""Make room for the right jaws at their place on a tube: phases of the grasper. Privileged."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from controller.expert import traction
from controller.expert.approach import SAC_ROOM_M, TUBE_ROOM_M
from controller.expert.arm_room import liver_of, liver_room_m
from controller.expert.jaw_room import firm_room_m, holds_wall, sac_room_m, tube_room_m
from controller.expert.line_errors import NO_ERRORS, LineErrors
from controller.expert.motion import FIRM_ROOM_M, Goal
from controller.expert.phase import Phase
from tissue_sim.frames import AWAY, Array, exponential, pose, unit
from tissue_sim.tools.arms import LEFT_ARM

if TYPE_CHECKING:
    from tissue_sim.world import World

WALL_SPARE_M = 0.0004  # by which the gallbladder's wall is drawn out of the jaws' way; assumed
GAIN_M = 0.0001  # a swing that makes less room is none; assumed
SWING_RAD, WAYS = 0.15, 8  # the swings that are compared; assumed
UNMOVED = np.eye(4)


@dataclass(frozen=True, kw_only=True)
class JawPlace:
    """The place on a tube where the right jaws are to close, and how open they come there.

    Attributes:
        tube: The tube.
        tool: The right tool.
        opening_rad: Opening of the jaws on their way.
        on_wall: Whether the jaws may close on the gallbladder's wall, too.
        target: Function from the world, and the jaws' opening over that on their way, to the goal.
        errors: What the observation is off.
    """

    tube: str
    tool: str
    opening_rad: float
    on_wall: bool
    target: Callable[..., Array]
    errors: LineErrors = NO_ERRORS

    def is_free(self, world: World, spare_m: float = 0.0) -> bool:
        """Return whether the gallbladder leaves the open jaws room, and the closed ones this."""
        if not self.on_wall and holds_wall(world, self.target(world, 0.0), self.tool, spare_m):
            return False
        return sac_room_m(world, self.target(world), self.tool, self.opening_rad) > SAC_ROOM_M

    def is_parted(self, world: World) -> bool:
        """Return whether other tubes leave the open jaws enough room."""
        T, rad = self.target(world), self.opening_rad
        return tube_room_m(world, self.tube, T, self.tool, rad, self.errors) > TUBE_ROOM_M

    def room_behind_m(self, world: World) -> float:
        """Return the gap from the open jaws to the liver and to firm obstacles, m."""
        return self.rooms_behind_m(world, (UNMOVED,))[0]

    def rooms_behind_m(self, world: World, motions: Sequence[Array]) -> list[float]:
        """Return the same for each motion (4, 4) of the place from where it is, world frame."""
        T, tool, rad, liver = self.target(world), self.tool, self.opening_rad, liver_of(world)
        return [
            min(
                liver_room_m(liver, motion @ T, tool, rad),
                firm_room_m(world, motion @ T, tool, rad, self.errors),
            )
            for motion in motions
        ]


def exposing(world: World, place: JawPlace) -> Iterator[Phase]:
    """Yield phases of the grasper that make room at a place; the last one eases the pull."""
    tube = place.tube
    yield _phase(
        "draw the tube straight",
        partial(traction.draw, tube),
        partial(traction.drawn, tube),
    )
    room = [phase for phase in (_swing(place, world), _aside(place, world)) if phase]
    yield from room
    if room or not traction.eased(world, 0.0):
        yield _phase("ease the pull", traction.ease, traction.eased)


def _swing(place: JawPlace, world: World) -> Phase | None:
    """Return the phase that swings the tube about its fixed end, clear of what stands beside it.

    Returns:
        None where the place has room already, or no swing gives it more.
    """
    before_m = place.room_behind_m(world)
    if before_m > FIRM_ROOM_M or clear_way(place, world)[1] < before_m + GAIN_M:
        return None

    def done(world: World, time_s: float) -> bool:
        room_m = place.room_behind_m(world)
        most = room_m > FIRM_ROOM_M or room_m > clear_way(place, world)[1]
        return most or traction.has_swung_clear(world, place.tube, time_s)

    def goal(world: World, start: Array) -> Goal:
        return traction.swing_clear(world, start, place.tube, clear_way(place, world)[0])

    return _phase("swing the tube clear", goal, done)


def clear_way(place: JawPlace, world: World) -> tuple[Array, float]:
    """Return the unit vector (3,) across the tube along which a swing makes most room, and that, m.

    The jaws' place turns with the tube about the tube's fixed end.
    """
    centres = world.tubes.centres(place.tube)
    along = unit(centres[-1] - centres[0])
    across = unit(AWAY - (AWAY @ along) * along)
    ways = [exponential(angle * along) @ across for angle in np.arange(WAYS) * 2.0 * np.pi / WAYS]
    quarter = exponential(0.5 * np.pi * along)
    swings = [about(centres[0], SWING_RAD * quarter @ way) for way in ways]
    rooms_m = place.rooms_behind_m(world, swings)
    best = int(np.argmax(rooms_m))
    return ways[best], rooms_m[best]


def about(point: Array, turn: Array) -> Array:
    """Return the motion (4, 4) that turns by a rotation vector (3,), rad, about a point (3,)."""
    R = exponential(turn)
    return pose(R, point - R @ point)


def _aside(place: JawPlace, world: World) -> Phase | None:
    """Return the phase that draws aside what covers the place, or lies beside it; None: nothing."""
    tube, tool = place.tube, place.tool
    if not place.is_free(world):
        return _phase(
            "draw the gallbladder aside",
            lambda w, start: traction.aside(w, start, place.target(w), tool, place.opening_rad),
            lambda w, time_s: place.is_free(w, WALL_SPARE_M) or traction.has_drawn(w, tube, time_s),
        )
    if not place.is_parted(world):
        return _phase(
            "part the tube from others",
            lambda w, start: traction.part(w, start, tube, place.target(w), tool),
            lambda w, time_s: place.is_parted(w) or traction.has_drawn(w, tube, time_s),
        )
    return None


def _phase(
    name: str, goal: Callable[[World, Array], Goal], done: Callable[[World, float], bool]
) -> Phase:
    return Phase(name=name, arm=LEFT_ARM, goal=goal, done=done)
