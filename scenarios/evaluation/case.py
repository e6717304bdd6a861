"""One episode of an evaluation: whose, under which condition, on which patient."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from scenarios.evaluation.arm import StudyArm
from scenarios.files.errors import WorkerDiedError
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.observer import Observer
from scenarios.loop.results import EpisodeResult
from scenarios.recording.attempt import attempt_episode, broken_off
from scenarios.suites import Condition


@dataclass(frozen=True, kw_only=True)
class Case:
    """Names an episode whole.

    Attributes:
        suite: a key of `scenarios.suites.SUITES`.
    """

    arm: StudyArm
    suite: str
    condition: Condition
    seed: int

    @property
    def config(self) -> EpisodeConfig:
        """What makes the episode, but for what is said in it."""
        return EpisodeConfig(
            scenario=self.condition.scenario,
            magnitude=self.condition.magnitude,
            seed=self.seed,
            **self.arm.choices,
        )

    @property
    def folder(self) -> Path:
        """Of the condition's episodes, in the report's: as `calot run` leaves them."""
        return Path(self.arm.name, self.suite, self.condition.name.replace(" ", "-"))

    @property
    def recording(self) -> Path:
        """In the report's folder."""
        return self.folder / "episodes" / f"{self.seed}.npz"


@dataclass(frozen=True, kw_only=True)
class Ended:
    """A case and what it came to.

    Attributes:
        unwritable: why its recording could not be kept; None if it was.
    """

    case: Case
    result: EpisodeResult
    unwritable: str | None = None


def attempt(case: Case, out: Path, observers: Sequence[Observer] = ()) -> Ended:
    """Runs it and leaves its recording in `out`.

    An episode that broke off is recorded, too: where there is no file there was no room for it.
    """
    from scenarios.loop.inbox import Inbox

    inbox, recording = Inbox(), out / case.recording
    try:
        recording.unlink(missing_ok=True)
        inbox.arrange(case.condition.said)
        result = attempt_episode(case.config, out / case.folder, observers, inbox)
    except OSError as error:
        return Ended(case=case, result=broken_off(case.config, error), unwritable=_why(error))
    unwritable = None if recording.exists() else f"{recording}: {result.error}"
    return Ended(case=case, result=result, unwritable=unwritable)


def after_death(case: Case, error: WorkerDiedError) -> Ended:
    """What stands for a case whose process died; it was not recorded and is run again later."""
    return Ended(case=case, result=broken_off(case.config, error))


def _why(error: OSError) -> str:
    return f"{error.filename or 'a file'}: {error.strerror or error}"
