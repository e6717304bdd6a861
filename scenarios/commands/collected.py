"""The report of `calot collect` on written, unwritable and interrupted episodes."""

from __future__ import annotations

from collections.abc import Sequence

from scenarios.demonstration.demonstrate import DemonstrationOutcome
from scenarios.files.errors import BadInputError


def written_or_refused(outcome: DemonstrationOutcome) -> DemonstrationOutcome:
    """Return the outcome of an episode that was written.

    Raises:
        BadInputError: The disk has no room for the episode.
    """
    if outcome.unwritable:
        raise BadInputError(
            f"--out: cannot write {outcome.unwritable}; finished episodes are complete: free some"
            " space and call again"
        )
    return outcome


def broken_lines(outcomes: Sequence[DemonstrationOutcome]) -> list[str]:
    """Return a line for each episode that broke off."""
    return [f"{o.demonstration.name} broke off: {o.error}" for o in outcomes if o.error]
