"""Benches of planner, controller, safety filter, a person's distances, and tampered input."""

from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Annotated, ClassVar, Literal

from tyro.conf import arg

from scenarios.catalogue import SCENARIOS
from scenarios.commands.bench_shared import ControllerOnTrial, Measurement, TrialBench, show
from scenarios.commands.typed_options import MOST_SEED, MOST_WORKERS, at_least, one_of
from scenarios.files.errors import FAILED
from scenarios.files.outside_text import Terminal

ASTRAY = ("grasp-missed-above", "grasp-missed-below", "wrong-tube", "both-tubes", "overshoot")
MIN_STEPS = 30  # some chunks join in them


@dataclass(frozen=True, kw_only=True)
class BenchController(Measurement):
    """Time a chunk of the diffusion controller, and measure how smoothly chunks join."""

    bench: ClassVar[str] = "scenarios.bench.controller:bench_controller"
    checkpoint: Annotated[Path | None, arg(metavar="FILE")] = None
    """Checkpoint; the default is the one that comes with Calot."""
    seed: Annotated[int, at_least(0, MOST_SEED)] = 10_000
    """Seed of the anatomy of the episodes."""
    repeats: Annotated[int, at_least(1)] = 300
    """Number of chunks to time."""
    steps: Annotated[int, at_least(MIN_STEPS)] = 600
    """Control steps of the episode at each delay."""


@dataclass(frozen=True, kw_only=True)
class BenchPlanner(Measurement):
    """Measure the learned planner's accuracy on rollouts that it was not trained on."""

    bench: ClassVar[str] = "scenarios.bench.planner:bench_planner"
    planner_checkpoint: Annotated[Path | None, arg(metavar="FILE")] = None
    """Checkpoint; none of this world version comes with Calot yet."""
    data: tuple[Path, ...] = (Path("runs/held_out"),)
    """Folders of rollouts, as `calot collect --mix rollouts` writes them."""


@dataclass(frozen=True, kw_only=True)
class Obedience(ControllerOnTrial):
    """Check whether each correction is obeyed, and the tube is clipped that is told.

    A planner's correction is heard by the controller alone; a person's is carried out by rule.
    """

    episodes: Annotated[int, at_least(1)] = 50
    """Number of patients, each tested at four times."""
    by: Literal["planner", "person"] = "planner"
    """Who says the corrections."""

    def execute(self) -> int:
        """Measure and report; return 1 if an error ended a trial."""
        from scenarios.bench.trials.obedience_trial import (
            ObedienceTrial,
            examine_obedience,
            obedience_table,
        )
        from scenarios.bench.trials.run_trials import TrialAttempt

        examination = partial(examine_obedience, config=self.config(), by=self.by)
        return self.report_trials(
            "words",
            TrialAttempt(run=examination, kind=ObedienceTrial),
            lambda trials, errors: [obedience_table(trials), *errors],
        )


@dataclass(frozen=True, kw_only=True)
class Corrections(ControllerOnTrial):
    """Measure the gain of a correction after an arm was led astray: with and without it."""

    scenario: Annotated[str, one_of(ASTRAY)] = "overshoot"
    """Scenario that leads an arm astray."""
    episodes: Annotated[int, at_least(1)] = 30
    """Number of patients, each corrected once."""

    def execute(self) -> int:
        """Measure and report; return 1 if an error ended a trial."""
        from scenarios.bench.trials.correction_trial import (
            CorrectionTrial,
            compare_forks,
            corrections_table,
        )
        from scenarios.bench.trials.run_trials import TrialAttempt

        comparison = partial(compare_forks, config=self.config(self.scenario))
        return self.report_trials(
            "corrections",
            TrialAttempt(run=comparison, kind=CorrectionTrial),
            lambda trials, errors: [corrections_table(trials), *errors],
        )


@dataclass(frozen=True, kw_only=True)
class WhatIf(ControllerOnTrial):
    """Go back to random moments of a procedure and say each correction: which help, which harm?"""

    scenario: Annotated[str, one_of(SCENARIOS)] = "nominal"
    """Scenario of the procedures."""
    episodes: Annotated[int, at_least(1)] = 10
    """Number of patients, each with four moments."""

    def execute(self) -> int:
        """Measure and report; return 1 if an error ended a trial."""
        from scenarios.bench.trials.run_trials import TrialAttempt
        from scenarios.bench.trials.what_if_trial import WhatIfTrial, ask_what_if, what_if_table

        asked = partial(ask_what_if, config=self.config(self.scenario))
        return self.report_trials(
            "moments",
            TrialAttempt(run=asked, kind=WhatIfTrial),
            lambda trials, errors: [what_if_table(trials), *errors],
        )


@dataclass(frozen=True, kw_only=True)
class Safety(TrialBench):
    """Check that the safety filter withstands attacks on each patient, and time it."""

    episodes: Annotated[int, at_least(1)] = 50
    """Number of patients; each is attacked 18 times at rest."""
    in_world: Annotated[int, at_least(0)] = 2
    """Number of attacks on each patient in the moving world."""
    workers: Annotated[int, at_least(1, MOST_WORKERS)] = 1
    """Number of processes for the attacks; times are measured before, in one process."""

    def execute(self) -> int:
        """Measure and report; return 1 if an attack passed the filter."""
        from scenarios.bench.safety import broken_lines, depth_tables, time_table
        from scenarios.bench.trials.attack_trial import AttackTrial, run_trial
        from scenarios.bench.trials.run_trials import TrialAttempt

        with Terminal(stderr=True).status("measuring: safety filter"):
            times = time_table(self.seed)
        return self.report_trials(
            "attacks",
            TrialAttempt(run=partial(run_trial, in_world=self.in_world), kind=AttackTrial),
            lambda trials, broken: [*depth_tables(trials), *broken, times],
            broken_lines,
        )


@dataclass(frozen=True, kw_only=True)
class Distances(ControllerOnTrial):
    """Check that arms go as far as a person says: in an exchange, at work and in a hold."""

    controller: Literal["diffusion", "expert"] = "expert"
    """Which controller; the diffusion controller carries the corrections out itself, at work."""
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

        config = replace(self.config(), sense="tracked")
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
