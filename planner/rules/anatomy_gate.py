"""Decide from observations whether the tubes have room for the procedure, before the first clip.

The gate applies the rule of `tissue_sim.outcome.room` to observations: the tubes' lengths, a
crossing of the tubes, and a third tube.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from planner.command import TUBES
from planner.scene.duct_side import structure_seen
from planner.scene.next_task import applier_on
from tissue_sim.outcome.clip_rule import FEWEST_CLIPS, needed_m
from tissue_sim.sensing.observation import Observation

# By how many standard deviations a tube must look too short. Before the first clip is due a call
# can wait until it is certain. Then half of one, some 0.3 mm, spares most needless calls: 3 of 43
# operable patients were called with a quarter (0.15 mm). A tube that is short by so little takes
# its clips by the tolerance of 0.8 mm in the clip rule's `CUT_ROOM_M`.
SURE, DUE = 2.0, 0.5
# Chances of a third tube. Until the gallbladder is grabbed it hides what tells one: three of 105
# tuning patients without one had 0.6 to 0.92 before, and one of them more than 0.5 after it.
CERTAIN, LIKELY = 0.98, 0.5
# Least mean distance of the artery's upper end beside the duct when the first clip is due.
# In truth 1 % of 441 operable patients have less than 2.5 mm, and no crossing artery has -1.7 mm.
# Perception placed arteries that cross behind the duct 4 mm too far over: 12 of 13 below 2.1 mm.
BESIDE_M = 0.0021


class AnatomyGate:
    """Collects observations of one patient's tubes until the first clip, and judges them.

    The gate judges until the first clip. It judges at least once when the robot's own clip or cut
    is due, because a person may have ordered others before.
    """

    def __init__(self) -> None:
        self._n, self._beside_m, self._judged = 0, 0.0, False

    def update(self, observation: Observation) -> None:
        """Take in one observation; observations after the first clip do not show the room."""
        if _is_untouched(observation):
            self._n += 1
            self._beside_m += artery_beside_m(observation)

    def why_call(self, observation: Observation, *, due: bool) -> str | None:
        """Return why a person must be called, in a surgeon's words; None if there is no reason.

        Args:
            observation: The last observation that was taken in.
            due: Whether a clip or a cut is next, so that uncertain cases must be decided now.
        """
        if not _is_untouched(observation) and (self._judged or not due):
            return None
        self._judged |= due
        return " ".join(self._reasons(observation, due=due)) or None

    def _reasons(self, observation: Observation, *, due: bool) -> Iterator[str]:
        for side, length_m, std_m, severed in zip(
            TUBES,
            observation.rest_length_m,
            observation.rest_length_std_m,
            observation.severed,
            strict=True,
        ):
            tube = structure_seen(side, observation)
            needs_m = needed_m(tube, applier_on(side, observation), FEWEST_CLIPS)
            if not severed and needs_m - length_m > (DUE if due else SURE) * std_m:
                yield (
                    f"The {tube} looks {1e3 * length_m:.1f} mm long: a clip on either side of"
                    f" a cut needs {1e3 * needs_m:.1f} mm."
                )
        if self._beside_m < (BESIDE_M if due else 0.0) * self._n:
            yield "The artery seems to cross the duct: a person must deal with it."
        if observation.third_tube > (LIKELY if due else CERTAIN):
            yield "There seems to be a second artery: a person must deal with it."


def _is_untouched(observation: Observation) -> bool:
    """Return whether nothing has been clipped or cut yet."""
    return not (observation.n_clips or observation.severed.any())


def artery_beside_m(observation: Observation) -> float:
    """Return the distance of the artery's upper end from the duct's line, in the endoscope's view.

    The distance is at the tubes' mean depth. It is negative if the upper end lies on the duct's
    other side than the lower end.
    """
    sides = zip(TUBES, (observation.left_tube_m, observation.right_tube_m), strict=True)
    lines = {structure_seen(side, observation): line for side, line in sides}
    duct, artery = (lines[tube][:, :2] / lines[tube][:, 2:] for tube in ("duct", "artery"))
    up = np.argsort(duct[:, 1])
    low, high = artery[[0, -1], 0] - np.interp(artery[[0, -1], 1], duct[up, 1], duct[up, 0])
    depth_m = 0.5 * (lines["duct"][:, 2].mean() + lines["artery"][:, 2].mean())
    return float(np.sign(low) * high * depth_m)
