"""`calot collect`: collect demonstrations by the expert, or labelled pictures, as a dataset."""

import math
import time
from collections.abc import Generator, Iterable, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated

from tyro.conf import arg

from scenarios.catalogue import SENSES
from scenarios.commands.cluster_option import require_cluster
from scenarios.commands.folder_options import claimed, require_kernel_cache, require_writable_folder
from scenarios.commands.policy_options import (
    require_cameras,
    require_checkpoint,
    require_renderer,
)
from scenarios.commands.typed_options import MOST_SEED, MOST_WORKERS, at_least, one_of
from scenarios.demonstration.alike import require_alike, require_pictures_alike
from scenarios.demonstration.demonstrate import (
    PARTS,
    DemonstrationOutcome,
    broken_off,
    demonstrate,
    is_finished,
)
from scenarios.demonstration.mix import (
    FORKED,
    LEARNED_MIXES,
    MIXES,
    ROLLOUT,
    TRAINING_SEEDS,
    PlannedDemonstration,
    demonstrations,
)
from scenarios.demonstration.pictures import frames_path, picture, pictured
from scenarios.files.errors import ERROR, BadInputError, refusing
from scenarios.files.outside_text import Terminal
from scenarios.loop.observer import ProgressDisplay
from scenarios.workers.pool import run_each

WITHOUT_PICTURES = tuple(name for name, sense in SENSES.items() if not sense.renders)


@dataclass(frozen=True, kw_only=True)
class Collect:
    """Let the expert demonstrate the procedure; continue where an earlier call stopped.

    Exit code: 0 done, 2 bad input or a full disk, 3 some episodes broke off, 130 interrupted.
    """

    out: Path
    """Folder of the dataset; new episodes are added to it."""
    seed: Annotated[int, at_least(0, MOST_SEED)] = 0
    """Seed of the first episode; each further one takes the next. Training seeds end at 9999."""
    episodes: Annotated[int, at_least(0)] = 100
    """Number of episodes; 0 rebuilds the dataset from the existing ones."""
    workers: Annotated[int, at_least(1, MOST_WORKERS)] = 1
    """How many episodes run in parallel."""
    cluster: Annotated[str | None, arg(metavar="HOST:PORT")] = None
    """Ray cluster that runs them; this machine must be one of its nodes."""
    mix: Annotated[str, one_of(MIXES)] = "all"
    """What is demonstrated: procedures without failures, recovery from failures, obeyed
    corrections, or all three; tubes in any order; turns of the expert and a learned controller,
    with recovery or without; or rollouts of the learned controller alone, labelled with the right
    instructions, whether they pass or fail."""
    checkpoint: Annotated[Path | None, arg(metavar="FILE")] = None
    """Checkpoint of the learned controller that takes turns with the expert or acts alone; the
    default is the one that comes with Calot."""
    planner_checkpoint: Annotated[Path | None, arg(metavar="FILE")] = None
    """Checkpoint of the learned planner in rollouts; the default is the scripted planner."""
    noise: bool = True
    """Disturb the expert's motion by bursts of noise, from which it recovers."""
    sense: Annotated[str, one_of(WITHOUT_PICTURES)] = "tracked"
    """What observation.environment_state is told by, and what a learned policy and the filter act
    on. The exact state is recorded beside it."""
    artery_below_mm: Annotated[int | None, at_least(16)] = None
    """Only patients whose artery is shorter than this; the default is all."""
    cameras: Annotated[tuple[str, ...], arg(metavar="NAME ...")] = ()
    """Cameras that film the episodes, a picture for each frame, for policies that see:
    endoscope_left, endoscope_right, wrist_left, wrist_right. Each stretch that the expert leads
    becomes an episode, and observation.state holds encoders and motor currents only."""
    pictures: bool = False
    """Take labelled pictures for `calot train perception` instead of demonstrations; of the other
    options only --out, --seed, --episodes and --checkpoint matter. With a checkpoint the learned
    controller acts in every other episode."""

    def execute(self) -> int:
        """Collect missing episodes, build the dataset, and report; return the exit code."""
        require_writable_folder(self.out, "--out")
        require_kernel_cache()
        if self.pictures and self.checkpoint:
            require_checkpoint("controller", "diffusion", self.checkpoint)
        elif not self.pictures:
            self._require_possible()
        with claimed(self.out, "--out"):
            if not self.pictures:
                return self._continue()
            return collect_pictures(self.seed, self.episodes, self.out, str(self.checkpoint or ""))

    def _continue(self) -> int:
        """Collect missing demonstrations, build the dataset, and report; return the exit code."""
        checkpoint = str(self.checkpoint or "")
        asked = demonstrations(
            self.mix,
            self.seed,
            self.episodes,
            noise=self.noise,
            checkpoint=checkpoint,
            planner=str(self.planner_checkpoint or ""),
            sense=self.sense,
            cameras=self.cameras,
            artery_below_m=math.inf if self.artery_below_mm is None else self.artery_below_mm / 1e3,
        )
        if len(asked) < self.episodes:
            given, kept = f"--seed {self.seed} --episodes {self.episodes}", "are left"
            if self.artery_below_mm is not None:
                given += f" --artery-below-mm {self.artery_below_mm}"
                kept += f" whose patient's artery is shorter than {self.artery_below_mm} mm"
            raise BadInputError(
                f"{given}: only {len(asked)} seeds {kept}; demonstrations take training seeds, 0 to"
                f" {TRAINING_SEEDS.stop - 1}"
            )
        require_alike(self.out, asked, self.cameras)
        waiting = [d for d in asked if not is_finished(d, self.out)]
        attempt = partial(demonstrate, out=self.out)
        start_s = time.perf_counter()
        each = run_each(attempt, waiting, self.workers, broken_off, self.cluster, here=attempt)
        outcomes = _collected(each, len(waiting))
        code = _told(_report(asked, outcomes, time.perf_counter() - start_s), outcomes)
        Terminal().print(self._merge(), soft_wrap=True)
        return code

    def _require_possible(self) -> None:
        if self.mix in LEARNED_MIXES:
            require_checkpoint("controller", "diffusion", self.checkpoint)
        elif self.checkpoint:
            raise BadInputError(f"--checkpoint is only for --mix {', '.join(LEARNED_MIXES)}")
        if self.planner_checkpoint:
            if not self.mix.startswith(ROLLOUT):
                raise BadInputError("--planner-checkpoint is only for --mix rollouts")
            require_checkpoint("planner", "learned", self.planner_checkpoint)
        if self.cameras and MIXES[self.mix][0] in FORKED:
            raise BadInputError("--cameras do not film forks: choose another --mix")
        require_cameras(self.cameras)
        require_cluster(self.cluster, self.out)

    def _merge(self) -> str:
        from controller.dataset.merge import merge

        parts = sorted((self.out / PARTS).glob("*.parquet"))
        before = f"--out: cannot write the dataset in {self.out} ("
        after = "); its episodes are complete: free some space and call again"
        with refusing(ValueError), refusing(OSError, before=before, after=after):
            frames = merge(parts, self.out)
        return f"dataset: {self.out}, {len(parts)} episodes, {frames} frames"


def _report(
    asked: Sequence[PlannedDemonstration], outcomes: Sequence[DemonstrationOutcome], wall_s: float
) -> list[str]:
    lines = _broken_lines(outcomes)
    passed = sum(outcome.success for outcome in outcomes)
    if outcomes:
        failed = len(outcomes) - passed - len(lines)
        rollouts = any(outcome.demonstration.is_rollout for outcome in outcomes)
        where = "with the others" if rollouts else "separately"
        lines.append(
            f"collected {len(outcomes)} episodes in {wall_s:.0f} s: {passed} passed,"
            f" {failed} failed and are kept {where}"
        )
    if there := len(asked) - len(outcomes):
        lines.append(f"{there} existed already")
    return lines


# Labelled pictures


def collect_pictures(first_seed: int, episodes: int, out: Path, checkpoint: str = "") -> int:
    """Take the missing labelled pictures, and report; return the exit code.

    An interrupted episode leaves no pictures; the next call tries it again.

    Raises:
        BadInputError: There is no renderer, or too few training seeds are left. The pictures in
            `out` were made in another way, or the disk is full.
    """
    require_renderer("--pictures")
    asked = pictured(first_seed, episodes, checkpoint)
    if len(asked) < episodes:
        raise BadInputError(
            f"--seed {first_seed} --episodes {episodes}: only {len(asked)} seeds are left;"
            f" pictures are of training seeds, 0 to {TRAINING_SEEDS.stop - 1}"
        )
    require_pictures_alike(out, asked)
    waiting = [d for d in asked if not frames_path(d, out).exists()]
    outcomes = _collected((picture(d, out) for d in waiting), len(waiting))
    broken = _broken_lines(outcomes)
    frames = sum(outcome.frames for outcome in outcomes)
    there, new = len(asked) - len(broken), len(waiting) - len(broken)
    line = f"pictures: {out}, {there} episodes, of them {new} new with {frames} frames"
    return _told((*broken, line), outcomes)


# Written, unwritable and interrupted episodes


def _collected(
    each: Generator[DemonstrationOutcome, None, None], n: int
) -> list[DemonstrationOutcome]:
    """Return the outcomes of `n` episodes, below a bar.

    Raises:
        BadInputError: The disk has no room for an episode.
    """
    outcomes: list[DemonstrationOutcome] = []
    with ProgressDisplay(n, Terminal(stderr=True)) as display, closing(each) as arriving:
        for outcome in arriving:
            if outcome.unwritable:
                raise BadInputError(
                    f"--out: cannot write {outcome.unwritable}; finished episodes are complete:"
                    " free some space and call again"
                )
            outcomes.append(outcome)
            display.advance()
    return outcomes


def _broken_lines(outcomes: Sequence[DemonstrationOutcome]) -> list[str]:
    """Return a line for each episode that broke off."""
    return [f"{o.demonstration.name} broke off: {o.error}" for o in outcomes if o.error]


def _told(lines: Iterable[str], outcomes: Sequence[DemonstrationOutcome]) -> int:
    """Print the lines; return the exit code."""
    for line in lines:
        Terminal().print(line, soft_wrap=True)
    return ERROR if any(outcome.error for outcome in outcomes) else 0
