"""How likely is a third tube? What all views say of it, joined over views and time."""

from __future__ import annotations

import numpy as np

from controller.perception.checkpoint import PerceptionConfig
from controller.perception.graph import Shown, ViewReader
from controller.perception.network import FLAGS

SHARE = 0.1  # of patients who have one: 29 of 300 (seeds 10700 to 10999)
_FLAG = FLAGS.index("third tube")


class ThirdTube:
    """Adds up what views say beyond what they say of a black picture, which shows nothing.

    Looks of one view err alike, so their mean counts, not their sum. Views count as independent.
    """

    def __init__(self, blind: dict[str, float]) -> None:
        """Take the logits of `blind_logits`."""
        self._blind, self._said = blind, dict.fromkeys(blind, 0.0)
        self._looks = dict.fromkeys(blind, 0)

    def look(self, shown: dict[str, Shown]) -> None:
        """Take in one look."""
        for view, seen in shown.items():
            self._looks[view] += 1
            beyond = float(seen.flags[_FLAG]) - self._blind[view]
            self._said[view] += (beyond - self._said[view]) / self._looks[view]

    @property
    def chance(self) -> float:
        """The probability of a third tube, 0 to 1."""
        odds = SHARE / (1.0 - SHARE) * np.exp(np.clip(sum(self._said.values()), -20.0, 20.0))
        return float(odds / (1.0 + odds))


def blind_logits(viewer: ViewReader, config: PerceptionConfig) -> dict[str, float]:
    """Return, by view, the logit of a third tube where a picture shows nothing."""
    sizes = zip(config.views, config.sizes, strict=True)
    black = {view: np.zeros((height, width, 3), np.uint8) for view, (width, height) in sizes}
    return {view: float(viewer(view, rgb).flags[_FLAG]) for view, rgb in black.items()}
