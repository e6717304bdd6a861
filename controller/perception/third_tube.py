"""Estimate the probability of a third tube from the endoscope's close crop, over time."""

from __future__ import annotations

import math

from controller.perception.graph import Shown
from controller.perception.network import FLAGS

VIEW = "endoscope_left_close"  # other views did not tell patients apart: 20 tuning patients
SHARE = 0.1  # of patients who have one: 29 of 300 (seeds 10700 to 10999)
SHARE_TRAINED = 0.2154  # of the frames of the shipped perception's training: 5,215 of 24,209
# Looks that count: about 3 s. The gallbladder hides the tubes' upper ends until it is grabbed. Of
# 172 tuning patients (seeds 12000 to 13145) who came to a first clip, the last looks classified
# 63 of 67 third tubes and 104 of 105 others; all looks since the beginning 63 and 102.
LOOKS = 8
_FLAG = FLAGS.index("third tube")


class ThirdTube:
    """Takes the view's logit beyond the logit of its training's frames as evidence.

    Looks of one patient err alike, so the mean of the last ones counts, not their sum.
    """

    def __init__(self) -> None:
        self._beyond, self._looks = 0.0, 0

    def look(self, shown: dict[str, Shown]) -> None:
        """Take in one look; a look without the view gives no evidence."""
        if VIEW not in shown:
            return
        self._looks = min(self._looks + 1, LOOKS)
        beyond = float(shown[VIEW].flags[_FLAG]) - _logit(SHARE_TRAINED)
        self._beyond += (beyond - self._beyond) / self._looks

    @property
    def chance(self) -> float:
        """Return the probability of a third tube, 0 to 1."""
        return 1.0 / (1.0 + math.exp(-_logit(SHARE) - self._beyond))


def _logit(share: float) -> float:
    return math.log(share / (1.0 - share))
