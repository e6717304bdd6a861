"""Describe the scene in words for a planner that reads, from the observation alone."""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees

import numpy as np

from planner.scene.duct_side import structure_seen
from planner.scene.next_task import clips_on
from tissue_sim.frames import Array
from tissue_sim.patient.tube_names import USUAL_TUBES, Tube
from tissue_sim.sensing.observation import Observation
from tissue_sim.sensing.polyline import distance_to_line_m
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM

AXES = (("left", "right"), ("higher", "lower"), ("further away", "nearer"))  # of the endoscope


def scene_in_words(observation: Observation) -> str:
    """Return tools, tubes, clips and forces in words; lengths in mm, directions as in the view."""
    return "\n".join(
        (
            f"Time: {observation.time_s:.0f} s.",
            _left_arm(observation),
            _right_arm(observation),
            *(_tube(tube, observation) for tube in observation.tubes),
        )
    )


def all_tubes(observation: Observation) -> str:
    """Return the words for all tubes that are there: "both tubes"."""
    return "both tubes" if len(observation.tubes) == len(USUAL_TUBES) else "all three tubes"


def joined(parts: Sequence[str]) -> str:
    """Return parts of a sentence as a list in words: "one, two and three"."""
    return " and ".join(filter(None, (", ".join(parts[:-1]), parts[-1])))


def way_in_words(way_m: Array) -> str:
    """Return a vector (3,), endoscope frame, in words in whole mm; "right there" if it is zero."""
    parts = [
        f"{abs(mm)} mm {words[0] if mm > 0 else words[1]}"
        for mm, words in zip(np.rint(1e3 * way_m).astype(int).tolist(), AXES, strict=True)
        if mm
    ]
    return ", ".join(parts) or "right there"


def _left_arm(observation: Observation) -> str:
    sac_m = observation.sac_m
    tip = observation.tips_endoscope[LEFT_ARM, :3, 3]
    nearest = sac_m[np.linalg.norm(sac_m - tip, axis=1).argmin()]
    way = way_in_words(nearest - tip)
    return f"Left arm: {_tool(LEFT_ARM, observation)}; from its tip to the gallbladder: {way}."


def _right_arm(observation: Observation) -> str:
    tool = _tool(RIGHT_ARM, observation)
    if observation.right_instrument.deed == "clip":
        tool += ", loaded" if observation.clip_loaded else ", without a clip"
    tip = observation.tips_endoscope[RIGHT_ARM, :3, 3]
    ways = "; ".join(_way_to(tube, tip, observation) for tube in observation.tubes)
    return f"Right arm: {tool}; {ways}."


def _way_to(tube: Tube, tip: Array, observation: Observation) -> str:
    line = observation.tube_m(tube)
    far_mm = 1e3 * distance_to_line_m(tip[None], line)[0]
    way = way_in_words(line.mean(axis=0) - tip)
    return f"from its tip to the middle of the {tube} tube: {way} ({far_mm:.0f} mm to its axis)"


def _tool(arm: int, observation: Observation) -> str:
    name = observation.tools[arm].replace("_", " ")
    opening = degrees(observation.joints[arm, 6])
    force_n = np.linalg.norm(observation.forces_n[arm])
    return f"{name}, jaws {opening:.0f} degrees open, tissue force {force_n:.1f} N"


def _tube(tube: Tube, observation: Observation) -> str:
    line = observation.tube_m(tube)
    along_m = np.linalg.norm(np.diff(line, axis=0), axis=1).sum()
    straight = np.linalg.norm(line[-1] - line[0]) / max(along_m, 1e-9)
    rest_mm = 1e3 * observation.length_m(tube)
    parts = "in two parts" if observation.is_severed(tube) else "in one part"
    return (
        f"{tube.capitalize()} tube ({structure_seen(tube, observation)}):"
        f" {clips_on(tube, observation)} clips, {parts}, {100 * straight:.0f} % straight,"
        f" {rest_mm:.0f} mm long at rest."
    )
