"""Save episodes in which a person intervened as a growing dataset.

As in YAY Robot (Shi et al., arXiv 2403.12910), a person's words train the planner.
"""

from __future__ import annotations

from itertools import count
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING

from controller.dataset.dataset_episode import DatasetEpisode as Demonstrated
from controller.dataset.dataset_episode import Header
from controller.dataset.merge import merge
from controller.dataset.part import part_bytes
from planner.learning.files import write_atomic
from scenarios.catalogue import ORACLE
from scenarios.demonstration.demonstrate import PARTS, failures_of
from scenarios.demonstration.demonstration_recorder import DemonstrationRecorder, is_frame
from scenarios.demonstration.mix import INTERVENTION, TRAINING_SEEDS
from scenarios.files.strict_json import plain
from scenarios.files.versions import versions
from scenarios.loop.episode_config import EpisodeConfig, checkpoint_digests
from scenarios.loop.results import EpisodeResult
from scenarios.loop.step import Step
from scenarios.workers.process import saving

if TYPE_CHECKING:
    from tissue_sim.world import World

_WRITING = Lock()  # a data set is written by one thread at a time


class Interventions:
    """Observes episodes that differ in their seeds, and saves completed ones with an intervention.

    Guiding an arm is an intervention. Commands such as stop and resume alone are none. Nothing is
    an intervention during a hold, of which no frame is kept.

    Attributes:
        intervened: Whether a person has intervened in the current episode.
        unsaved: The reason why the last completed episode could not be saved; "" for none.
    """

    def __init__(self, out: Path, config: EpisodeConfig) -> None:
        """Save to `out`; of the controllers' motions only the expert's are to be imitated."""
        self._out, self._config = out, config
        self._expert = config.controller == ORACLE["controller"]
        self.intervened, self.unsaved = False, ""

    def on_reset(self, world: World) -> None:
        """Begin an episode, without intervention so far."""
        self._anatomy, self.intervened, self.unsaved = world.anatomy, False, ""
        self._path: Path | None = None  # once the episode has been saved
        self._recorder = DemonstrationRecorder(lambda: self._expert)
        self._recorder.on_reset(world)

    def on_step(self, step: Step) -> None:
        """Add one step."""
        self._recorder.on_step(step)
        by_person = step.instruction.source == "human" or step.guided is not None
        self.intervened |= by_person and is_frame(step)

    def on_end(self, result: EpisodeResult) -> None:
        """Save the episode with its result; a full disk leaves the result unchanged."""
        try:
            with saving():
                self.save(result.success, failures_of(result))
        except (OSError, ValueError) as error:
            self.unsaved = " ".join(str(error).split())

    def save(self, success: bool, failures: list[str]) -> Path | None:
        """Save the episode so far to a file and the dataset; return None without intervention.

        A later save of the same episode replaces the earlier one. Any thread may save while another
        thread adds steps; the other thread does not wait.

        Raises:
            OSError: The file cannot be written.
            ValueError: The folder holds parts that do not fit, or the seed is none of training.
        """
        if not self.intervened:
            return None
        if self._anatomy.seed not in TRAINING_SEEDS:
            allowed = f"0 to {TRAINING_SEEDS.stop - 1}"
            raise ValueError(
                f"seed {self._anatomy.seed} is no training patient; allowed: {allowed}"
            )
        with _WRITING:
            return self._write(success, failures)

    def _write(self, success: bool, failures: list[str]) -> Path:
        seed = self._anatomy.seed
        header = Header(
            seed=seed,
            kind=INTERVENTION,
            scenario=self._config.scenario,
            success=success,
            failures=failures,
            anatomy=plain(self._anatomy),
            versions=versions(),
            sense=self._config.sense,
            checkpoints=checkpoint_digests(self._config),
        )
        episode = Demonstrated(header=header, columns=self._recorder.columns(seed, INTERVENTION))
        parts = self._out / PARTS
        paths = (parts / f"{seed:05d}-{INTERVENTION}-{n:03d}.parquet" for n in count())
        self._path = self._path or next(path for path in paths if not path.exists())
        write_atomic(self._path, part_bytes(episode))
        merge(sorted(parts.glob("*.parquet")), self._out)
        return self._path
