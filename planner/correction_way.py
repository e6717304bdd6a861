"""Measure what is left of a planner's correction: the distance of an arm, the opening of jaws."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from planner.correction import DIRECTION_ENDOSCOPE, Correction
from planner.instruction import Instruction
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import Observation


class CorrectionWay:
    """Follows the planner's correction in force from the observation at which it began.

    A person's correction is measured where it is kept (`planner.person.orders`).
    """

    def __init__(self) -> None:
        self._begun: tuple[str, float] | None = None

    def update(self, said: Instruction, observation: Observation) -> Instruction:
        """Return the planner's instruction with what is left of the distance or angle it named."""
        if said.source != "planner" or said.correction is None:
            self._begun = None
            return said
        if self._begun != (said.text, said.time_s):
            self._begun = said.text, said.time_s
            self._start_m, self._start_rad = _tips_m(observation), _jaws_rad(observation)
        correction = said.correction
        if correction.direction is not None and said.left_m is not None:
            gone_m = moved_m(correction, _tips_m(observation) - self._start_m)
            return replace(said, left_m=said.left_m - gone_m)
        if correction.jaw is not None and said.left_rad is not None:
            gone_rad = opened_rad(correction, _jaws_rad(observation) - self._start_rad)
            return replace(said, left_rad=said.left_rad - gone_rad)
        return said


def moved_m(correction: Correction, tips_m: Array) -> float:
    """Return how far the named arm went the named way, from motions (2, 3), endoscope frame."""
    assert correction.direction is not None, "an arm is corrected"
    (arm,) = correction.rows
    return float(tips_m[arm] @ DIRECTION_ENDOSCOPE[correction.direction])


def opened_rad(correction: Correction, jaws_rad: Array) -> float:
    """Return how far all named jaws opened or closed as named, from changes (2,) of angles."""
    sign = 1.0 if correction.jaw == "open" else -1.0
    return float((sign * jaws_rad[correction.rows]).min())


def _tips_m(observation: Observation) -> Array:
    return np.array(observation.tips_endoscope[:, :3, 3])


def _jaws_rad(observation: Observation) -> Array:
    return np.array(observation.joints[:, -1])
