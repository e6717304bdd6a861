"""Draw the gallbladder with the grasper: straighten, spread, part and ease the tubes. Privileged.

Goals are functions of the world and of the tool's pose at the phase's start. Ends of phases are
functions of the world and of the time in the phase, s.
"""

from __future__ import annotations

from collections.abc import Sequence
from operator import itemgetter
from typing import TYPE_CHECKING

import numpy as np

from controller.expert.jaw_room import axis_side, side_of_sac, side_of_tubes
from controller.expert.motion import PHASE_MAX_S, Goal
from tissue_sim.frames import AWAY, Array, unit
from tissue_sim.outcome.predicates import gallbladder_held, gap_m, straightness, tube_severed
from tissue_sim.patient.organ import TUBES
from tissue_sim.patient.tubes import Tubes
from tissue_sim.thresholds import GRASP_MIN_TRACTION_N, MAX_STRETCH, SPREAD_MIN_M
from tissue_sim.tools.arms import LEFT_ARM

if TYPE_CHECKING:
    from tissue_sim.world import World

PULL_STEP_M, PULL_SPEED_M_S = 0.004, 0.006  # assumed, as the forces and times below
PULL_MIN_N, PULL_MAX_N = 2.0 * GRASP_MIN_TRACTION_N, 2.5  # some is lost as tissue settles
SWING_MAX_N = 3.5  # while a straight tube turns about its fixed end
ASIDE_MAX_N = 1.0  # draws the gallbladder aside: a thin artery bears little more
TIGHT_STRETCH = 1.1  # of a thin tube, which a small pull straightens; assumed
DRAWN_STRETCH = 1.0 + 0.9 * (MAX_STRETCH - 1.0)  # of a tube, by the arms; assumed
EASED_STRETCH = 1.0 + 0.8 * (MAX_STRETCH - 1.0)  # which leaves the right arm some; assumed
TAUT = 0.990  # chord over length of a tube that is pulled no further; assumed
MIN_MISSING = 0.001  # of a tube's length: keeps the direction when all are straight; assumed
LIFT = 0.35  # share of the pull towards the endoscope, off the liver; assumed
SPREAD_SPARE_M, SPREAD_MAX_S, DRAW_MAX_S = 0.0004, 3.0, 3.0


def _towards(world: World, start: Array, direction: Array) -> Goal:
    """Return a step of the grasper along a unit vector (3,), world frame, turned as at `start`.

    The step is short where a tube is nearly stretched as far as it may be.
    """
    stretches, lengths_m = world.tubes.stretches(), world.tubes.length_m
    left_m = min(
        ((DRAWN_STRETCH - stretches[t]) * lengths_m[t] for t in _whole(world)), default=np.inf
    )
    return _step(world, start, float(np.clip(left_m, 0.0, PULL_STEP_M)) * direction)


def _step(world: World, start: Array, step_m: Array) -> Goal:
    """Return a step (3,) of the grasper, m, without what presses the gallbladder into the liver."""
    T = world.arms.T_world_tool()[LEFT_ARM].copy()
    T[:3, 3] += step_m - max(step_m @ AWAY, 0.0) * AWAY
    T[:3, :3] = start[:3, :3]
    return Goal(T_world_tool=T, speed_m_s=PULL_SPEED_M_S)


def pull(world: World, start: Array) -> Goal:
    """Return a step of the grasper that straightens the tubes, the slackest one most."""
    return _towards(world, start, pull_direction(world.tubes))


def pulled(world: World, time_s: float) -> bool:
    """Return whether all tubes are straight, or the grasper can straighten them no further."""
    traction_n = world.record.grasp.traction_n
    enough = taut(world.tubes) and traction_n > PULL_MIN_N
    return enough or traction_n > PULL_MAX_N or time_s > PHASE_MAX_S


def swing(world: World, start: Array) -> Goal:
    """Return a step of the grasper that straightens the slack tubes, across the straight ones."""
    tubes = world.tubes
    way = pull_direction(tubes)
    for tube in TUBES:
        centres = tubes.centres(tube)
        along = unit(centres[-1] - centres[0])
        if taut(tubes, (tube,)):
            way = way - max(way @ along, 0.0) * along
    return _towards(world, start, unit(way))


def swung(world: World, time_s: float) -> bool:
    """Return whether all tubes are straight, or none is, or the grasper pulls too hard."""
    straight = [taut(world.tubes, (tube,)) for tube in TUBES]
    traction_n = world.record.grasp.traction_n
    return all(straight) or not any(straight) or traction_n > SWING_MAX_N or time_s > DRAW_MAX_S


def spread(world: World, start: Array) -> Goal:
    """Return a step of the grasper that parts duct and artery."""
    return _towards(world, start, spread_direction(world.tubes))


def is_spread(world: World, time_s: float) -> bool:
    """Return whether duct and artery are apart, or the grasper can part them no further."""
    wide = gap_m(world.tubes) > SPREAD_MIN_M + SPREAD_SPARE_M
    return wide or world.record.grasp.traction_n > PULL_MAX_N or time_s > SPREAD_MAX_S


def draw(tube: str, world: World, start: Array) -> Goal:
    """Return a step of the grasper that straightens one tube."""
    return _towards(world, start, pull_direction(world.tubes, (tube,)))


def drawn(tube: str, world: World, time_s: float) -> bool:
    """Return whether a tube is straight, or the grasper can straighten it no further.

    Where the other tube is cut, the gallbladder hangs on this tube alone.
    """
    traction_n = world.record.grasp.traction_n
    held = gallbladder_held(world) and not tube_severed(world, tube)
    tight = traction_n > PULL_MIN_N or world.tubes.stretches()[tube] > TIGHT_STRETCH
    enough = taut(world.tubes, (tube,)) and tight
    most = traction_n > PULL_MAX_N or is_drawn_out(world)
    return not held or enough or most or time_s > DRAW_MAX_S


def aside(world: World, start: Array, T_world_tool: Array, tool: str, opening_rad: float) -> Goal:
    """Return a step of the grasper that draws the gallbladder out of the right jaws' way."""
    side = side_of_sac(world, T_world_tool, tool, opening_rad) or axis_side(world, T_world_tool)
    return _towards(world, start, side * T_world_tool[:3, 1])


def part(world: World, start: Array, tube: str, T_world_tool: Array, tool: str) -> Goal:
    """Return a step of the grasper that draws the tube away from the nearest other one."""
    side = side_of_tubes(world, tube, T_world_tool, tool)
    return _towards(world, start, -side * T_world_tool[:3, 1])


def has_drawn(world: World, tube: str, time_s: float) -> bool:
    """Return whether the grasper may draw the gallbladder aside no further."""
    held = gallbladder_held(world) and not tube_severed(world, tube)
    free = world.record.grasp.traction_n < ASIDE_MAX_N and not is_drawn_out(world)
    return not (held and free) or time_s > DRAW_MAX_S


def swing_clear(world: World, start: Array, tube: str, way: Array) -> Goal:
    """Return a step of the grasper along a unit vector (3,) across a tube, on an arc about its end.

    The step goes towards the tube's fixed end where the tube is stretched too far to follow.
    """
    centres = world.tubes.centres(tube)
    tight = world.tubes.stretches()[tube] > EASED_STRETCH
    back = unit(centres[0] - centres[-1]) if tight else np.zeros(3)
    return _step(world, start, PULL_STEP_M * unit(way + back))


def has_swung_clear(world: World, tube: str, time_s: float) -> bool:
    """Return whether the grasper may swing the tube no further."""
    held = gallbladder_held(world) and not tube_severed(world, tube)
    return not held or world.record.grasp.traction_n > PULL_MAX_N or time_s > DRAW_MAX_S


def ease(world: World, start: Array) -> Goal:
    """Return a step of the grasper that slackens the tube that is stretched the most."""
    if eased(world, 0.0):
        return Goal()
    centres = world.tubes.centres(_most_stretched(world)[0])
    back = unit(centres[0] - centres[-1])
    return _step(world, start, PULL_STEP_M * back)


def eased(world: World, time_s: float) -> bool:
    """Return whether no tube is stretched so far that the right arm may not move it."""
    held = gallbladder_held(world)
    return not held or _most_stretched(world)[1] < EASED_STRETCH or time_s > DRAW_MAX_S


def is_drawn_out(world: World) -> bool:
    """Return whether a whole tube is stretched so far that neither arm may draw it further.

    The right arm draws tubes, too, where the grasper must give way to it.
    """
    return _most_stretched(world)[1] > DRAWN_STRETCH


def _most_stretched(world: World) -> tuple[str, float]:
    """Return the whole tube with the most stretch, and its stretch: 1 for none."""
    stretches = world.tubes.stretches()
    return max(((t, stretches[t]) for t in _whole(world)), key=itemgetter(1), default=("", 1.0))


def _whole(world: World) -> list[str]:
    return [tube for tube in world.organ.tubes if not tube_severed(world, tube)]


def pull_direction(tubes: Tubes, chosen: Sequence[str] = TUBES) -> Array:
    """Return a unit vector that straightens tubes, the slackest tube most, off the liver."""
    total = np.zeros(3)
    for tube in chosen:
        centres = tubes.centres(tube)
        missing = max(TAUT + 0.005 - straightness(tubes, tube), MIN_MISSING)
        total += missing * tubes.length_m[tube] * unit(centres[-1] - centres[0])
    return unit(unit(total) - LIFT * AWAY)


def spread_direction(tubes: Tubes) -> Array:
    """Return a unit vector along which the gallbladder's pull parts duct and artery the fastest.

    A point at the share f of a tube's length moves by f of the gallbladder's motion. So the vector
    between the nearest points of the walls grows along itself if the artery's share is larger.
    """
    duct, artery = (tubes.centres(tube) for tube in TUBES)
    apart = artery[None] - duct[:, None]
    far_m = np.linalg.norm(apart, axis=-1)
    far_m[: len(duct) // 4] = far_m[len(duct) - len(duct) // 4 :] = np.inf
    far_m[:, : len(artery) // 4] = far_m[:, len(artery) - len(artery) // 4 :] = np.inf
    i, j = np.unravel_index(int(far_m.argmin()), far_m.shape)
    return float(np.sign(j * len(duct) - i * len(artery)) or 1.0) * unit(apart[i, j])


def taut(tubes: Tubes, chosen: Sequence[str] = TUBES) -> bool:
    """Return whether tubes are straight."""
    return min(straightness(tubes, tube) for tube in chosen) >= TAUT
