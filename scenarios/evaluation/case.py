"""One episode of an evaluation: its system, condition and patient."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from scenarios.evaluation.arm import StudyArm
from scenarios.files.errors import WorkerDiedError
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.observer import Observer
from scenarios.recording.attempt import Attempt, attempt_episode, lost
from scenarios.suites import Condition


@dataclass(frozen=True, kw_only=True)
class Case:
    """Everything that identifies an episode of an evaluation.

    Attributes:
        suite: A key of `scenarios.suites.SUITES`.
    """

    arm: StudyArm
    suite: str
    condition: Condition
    seed: int

    @property
    def config(self) -> EpisodeConfig:
        """Return the episode's configuration, without people's words."""
        return EpisodeConfig(
            scenario=self.condition.scenario,
            magnitude=self.condition.magnitude,
            seed=self.seed,
            **self.arm.stack,
        )

    @property
    def folder(self) -> Path:
        """Return the folder of the condition's episodes, relative to the report's folder."""
        return Path(self.arm.name, self.suite, self.condition.name.replace(" ", "-"))

    @property
    def recording(self) -> Path:
        """Return the path of the recording, relative to the report's folder."""
        return self.folder / "episodes" / f"{self.seed}.npz"


Ended = tuple[Case, Attempt]


def attempt(case: Case, out: Path, observers: Sequence[Observer] = ()) -> Ended:
    """Run a case and save its recording in `out`."""
    from scenarios.loop.person.inbox import Inbox

    inbox = Inbox()
    inbox.arrange(case.condition.said)
    return case, attempt_episode(case.config, out / case.folder, observers, inbox)


def after_death(case: Case, error: WorkerDiedError) -> Ended:
    """Return the result of a case whose process died; without a recording, it runs again later."""
    return case, lost(case.config, error)
