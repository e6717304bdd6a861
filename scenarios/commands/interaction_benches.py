"""Benches of what comes from outside: a person's distances, and tampered input."""

from dataclasses import dataclass
from functools import partial
from typing import Annotated, Literal

from scenarios.commands.bench_shared import TrialBench, show
from scenarios.commands.typed_options import at_least
from scenarios.files.errors import FAILED
from scenarios.files.outside_text import Terminal


@dataclass(frozen=True, kw_only=True)
class Distances(TrialBench):
    """Check that arms go as far as a person says: in an exchange, at work and in a hold."""

    episodes: Annotated[int, at_least(1)] = 7
    """Number of patients, with a correction in each exchange, and some between them."""

    def execute(self) -> int:
        """Measure and report; return 1 if an error ended a trial."""
        from scenarios.bench.trials.distance_trial import (
            DistanceTrial,
            distances_table,
            examine_distances,
        )
        from scenarios.bench.trials.run_trials import TrialAttempt
        from scenarios.loop.episode_config import EpisodeConfig

        config = EpisodeConfig(scenario="textbook", seed=self.seed)
        return self.report_trials(
            "distances",
            TrialAttempt(run=partial(examine_distances, config=config), kind=DistanceTrial),
            lambda trials, errors: [distances_table(trials), *errors],
        )


@dataclass(frozen=True, kw_only=True)
class Faults:
    """Tamper with what Calot reads, by chance, and count how it ends."""

    kind: Literal["files", "texts", "clients", "processes"] = "files"
    """Which faults."""
    inputs: Annotated[int | None, at_least(1)] = None
    """Number of faults; by default 5000 files or texts, 500 clients of a page, 60 commands."""
    seed: Annotated[int, at_least(0)] = 0
    """Seed of the edits; an input of a seed is always the same."""

    def execute(self) -> int:
        """Try and report; return 1 if an input did harm."""
        from scenarios.bench.faults import KINDS
        from scenarios.bench.trials.tampering import summary_lines, tally_table

        with Terminal(stderr=True).status("tampering"):
            kind = KINDS[self.kind]
            tallies = kind.tally(self.inputs or kind.inputs, self.seed)
        show([tally_table(tallies), *summary_lines(tallies)])
        return 0 if all(tally.is_good for tally in tallies.values()) else FAILED
