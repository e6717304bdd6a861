"""The episodes of an evaluation: those of each condition, and of ladders as far as needed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from scenarios.evaluation.arm import StudyArm
from scenarios.evaluation.case import Case
from scenarios.loop.results import EpisodeResult, summarise
from scenarios.suites import Condition, Ladder, Suite

HOLDS = 0.5  # a rung holds if at least this share of its episodes passes

Results = Mapping[Case, EpisodeResult]


@dataclass(frozen=True, kw_only=True)
class Plan:
    """Systems, suites and patients of an evaluation; every system meets every patient."""

    arms: tuple[StudyArm, ...]
    suites: tuple[Suite, ...]
    seeds: Sequence[int]

    def cases(self, arm: StudyArm, suite: Suite, condition: Condition) -> list[Case]:
        """Return the cases of one condition, one for each patient."""
        return [
            Case(arm=arm, suite=suite.name, condition=condition, seed=seed) for seed in self.seeds
        ]

    def conditions(self, arm: StudyArm, suite: Suite, results: Results) -> list[Condition]:
        """Return the conditions for a system, with the rungs that the results so far call for."""
        rungs = (
            rung for ladder in suite.ladders for rung in self.climbed(arm, suite, ladder, results)
        )
        return [*suite.conditions, *rungs]

    def climbed(
        self, arm: StudyArm, suite: Suite, ladder: Ladder, results: Results
    ) -> Iterator[Condition]:
        """Yield the rungs of a ladder up to the first that is not finished or does not hold."""
        for rung in ladder.rungs:
            yield rung
            cases = self.cases(arm, suite, rung)
            if any(case not in results for case in cases):
                return
            rate = summarise([results[case] for case in cases]).pass_rate
            if rate is None or rate < HOLDS:
                return

    def asked(self, arm: StudyArm, suite: Suite, results: Results) -> list[Case]:
        """Return a system's cases in a suite, as far as the results so far call for them."""
        conditions = self.conditions(arm, suite, results)
        return [case for c in conditions for case in self.cases(arm, suite, c)]

    def due(self, results: Results) -> list[Case]:
        """Return the cases that can run now and have no result yet."""
        return [case for case in self._all(results) if case not in results]

    def known(self, results: Results) -> list[Case]:
        """Return the cases that have a result, in the plan's order."""
        return [case for case in self._all(results) if case in results]

    def _all(self, results: Results) -> Iterator[Case]:
        for suite in self.suites:
            for arm in self.arms:
                yield from self.asked(arm, suite, results)
