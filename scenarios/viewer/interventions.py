"""What people did in an episode, as training data when they ask for it, and not by itself."""

from __future__ import annotations

from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING

from scenarios.demonstration.interventions import Interventions
from scenarios.loop.results import EpisodeResult

if TYPE_CHECKING:
    from scenarios.loop.step import Step


class InterventionsOnRequest(Interventions):
    """May be asked from any thread, in the midst of an episode."""

    def __init__(self, out: Path, scenario: str, *, expert: bool) -> None:
        super().__init__(out, scenario, expert=expert)
        self._lock = Lock()

    def on_step(self, step: Step) -> None:
        """One frame more."""
        with self._lock:
            super().on_step(step)

    def on_end(self, result: EpisodeResult) -> None:
        """Saves nothing."""

    def save_so_far(self) -> Path:
        """The episode so far; nobody knows yet what it will come to.

        Raises:
            OSError: it cannot be written.
            ValueError: nobody has intervened, or the folder holds parts that do not fit.
        """
        with self._lock:
            path = self.save(success=False, failures=[])
        if path is None:
            raise ValueError("nobody has corrected anything or led an arm yet")
        return path
