"""Report whether jaws have opened or closed as a person requested, by their observed angle."""

from __future__ import annotations

from collections.abc import Collection
from math import degrees

from planner.correction import Correction
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import Observation
from tissue_sim.thresholds import HELD_PINCH_N
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM

SHUT_RAD = 0.1  # jaws that are open by less are closed; assumed
MOST = 0.5  # share of the requested angle at which a motion counts as done: jaws lag; assumed
SIDES = ("left", "right")


def jaws_told(
    said: Correction,
    asked_rad: float,
    start_rad: Array,
    observation: Observation,
    forbidden: Collection[str],
    withheld: str = "",
) -> str:
    """Return in words the result of a person's order to open or close jaws.

    Args:
        said: The correction: to open or to close, and which jaws.
        asked_rad: The requested change of the angle.
        start_rad: (2,) angles of the jaws as the order began.
        observation: The present observation.
        forbidden: Acts that a person forbade, in words.
        withheld: Reason why the safety filter altered the last command; "" if it did not.
    """
    left = [arm for arm in said.rows if not _has_done(said, arm, asked_rad, start_rad, observation)]
    if not left:
        return f"Done: {said.text}."
    angles = " and ".join(_angle(arm, start_rad, observation) for arm in left)
    return f"Not done: {said.text}; {angles}. {_why(said, left, observation, forbidden, withheld)}"


def _has_done(
    said: Correction, arm: int, asked_rad: float, start_rad: Array, observation: Observation
) -> bool:
    now_rad = float(observation.joints[arm, -1])
    closes = said.jaw == "close"
    moved_rad = (float(start_rad[arm]) - now_rad) * (1.0 if closes else -1.0)
    grips = arm == LEFT_ARM and observation.pinch_n >= HELD_PINCH_N
    return moved_rad >= MOST * asked_rad or (closes and (now_rad <= SHUT_RAD or grips))


def _angle(arm: int, start_rad: Array, observation: Observation) -> str:
    now, before = (degrees(rad) for rad in (observation.joints[arm, -1], start_rad[arm]))
    return f"the {SIDES[arm]} jaws are {now:.0f} degrees open, {before:.0f} before"


def _why(
    said: Correction,
    arms: Collection[int],
    observation: Observation,
    forbidden: Collection[str],
    withheld: str,
) -> str:
    """Return in words the known reason why jaws did not move as requested."""
    act = observation.right_instrument.deed
    bans = [ban for ban in forbidden if ban.split()[0] == act]
    if said.jaw == "close" and RIGHT_ARM in arms and bans:
        return f"You forbade: {', '.join(bans)}."
    if withheld:
        return f"The safety filter: {withheld}."
    if said.jaw == "close":
        return "An interlock of the safety filter keeps them, or what is between them."
    return "They are at their limit, or something is in the way."
