"""Save interventions as training data only on a person's request."""

from __future__ import annotations

from pathlib import Path

from scenarios.demonstration.interventions import Interventions
from scenarios.loop.results import EpisodeResult


class InterventionsOnRequest(Interventions):
    """Observes an episode; any thread may save it during the episode."""

    def on_end(self, result: EpisodeResult) -> None:
        """Save nothing: a person decides."""

    def save_so_far(self) -> Path:
        """Save the episode so far, marked as not successful because its result is unknown.

        Raises:
            OSError: The file cannot be written.
            ValueError: No person has intervened, or the folder holds parts that do not fit.
        """
        path = self.save(success=False, failures=[])
        if path is None:
            raise ValueError("nobody has corrected anything yet, or led an arm outside a hold")
        return path
