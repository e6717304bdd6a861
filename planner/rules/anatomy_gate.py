"""Decide from observations whether the tubes have room for the procedure, before the first clip.

The gate applies the rule of `tissue_sim.outcome.room` to the observed lengths of the tubes.
"""

from __future__ import annotations

from collections.abc import Iterator

from planner.scene.duct_side import structure_seen
from planner.scene.next_task import applier_on
from tissue_sim.outcome.clip_rule import FEWEST_CLIPS, needed_m, too_short
from tissue_sim.sensing.observation import Observation

# By how many standard deviations a tube must look too short. Before the first clip is due a call
# can wait until it is certain. Then half of one, some 0.3 mm, spares most needless calls: 3 of 43
# operable patients were called with a quarter (0.15 mm). A tube that is short by so little takes
# its clips by the tolerance of 0.8 mm in the clip rule's `CUT_ROOM_M`.
SURE, DUE = 2.0, 0.5


class AnatomyGate:
    """Judges the room on one patient's tubes.

    The gate judges until the first clip. It judges at least once when the robot's own clip or cut
    is due, because a person may have ordered others before.
    """

    def __init__(self) -> None:
        self._judged = False

    def why_call(self, observation: Observation, *, due: bool) -> str | None:
        """Return why a person must be called, in a surgeon's words; None if there is no reason.

        Args:
            observation: The present observation; after the first clip it does not show the room.
            due: Whether a clip or a cut is next, so that uncertain cases must be decided now.
        """
        if not _is_untouched(observation) and (self._judged or not due):
            return None
        self._judged |= due
        return room_in_words(observation, stds=DUE if due else SURE) or None


def room_in_words(observation: Observation, *, stds: float = 0.0) -> str:
    """Return which tubes look too short by more than some standard deviations; "" if none does."""
    return " ".join(_reasons(observation, stds))


def _reasons(observation: Observation, stds: float) -> Iterator[str]:
    for side in observation.tubes:
        tube, length_m = structure_seen(side, observation), observation.length_m(side)
        needs_m = needed_m(tube, applier_on(side, observation), FEWEST_CLIPS)
        if observation.is_severed(side):
            continue
        if needs_m - length_m > stds * observation.length_std_m(side):
            yield too_short(f"The {tube} looks", length_m, needs_m)


def _is_untouched(observation: Observation) -> bool:
    """Return whether nothing has been clipped or cut yet."""
    return not (observation.n_clips or observation.severed.any())
