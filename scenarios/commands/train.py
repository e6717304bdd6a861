"""`calot train`: train a controller or a planner on demonstrations."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Annotated, Any

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.text import Text
from tyro.conf import Positional, arg

from controller.dataset.choice import Choice
from scenarios.commands.folder_options import claimed, require_writable_folder
from scenarios.commands.typed_options import (
    MOST_SEED,
    MOST_STEPS,
    MOST_WORKERS,
    at_least,
    number,
    one_of,
    some_of,
)
from scenarios.demonstration.mix import KINDS
from scenarios.files.errors import BadInputError, refusing
from scenarios.files.outside_text import Terminal, visible

if TYPE_CHECKING:  # heavy to import
    from planner.learning.optimise import Schedule, TrainingStep

LEARNERS = ("controller", "planner", "perception", "pixels")
PRESETS = ("full", "smoke")
DEVICES = ("cpu", "cuda")
SLOW_BFLOAT16 = (
    "--bfloat16: this processor has no instructions for it, and is many times faster without"
)


@dataclass(frozen=True, kw_only=True)
class Train:
    """Train on demonstrations; the same call again continues where training was stopped."""

    learner: Positional[Annotated[str, one_of(LEARNERS)]]
    """What to train: the diffusion controller, the learned planner, perception, or the controller
    from pixels."""
    data: tuple[Path, ...] = (Path("runs/demonstrations"),)
    """Folders of demonstrations, as `calot collect` writes them; for the perception,
    of `calot collect --pictures`; for the controller from pixels, of `calot collect --cameras`."""
    leave_out: Annotated[tuple[str, ...], some_of(KINDS)] = ()
    """Kinds of demonstrations to leave out, separated by commas, for ablations."""
    share: Annotated[float, number()] = 1.0
    """Share of each folder's demonstrations to use, the first ones."""
    wordless: bool = False
    """Train a controller without instructions: SRT-H's ablation "no hierarchy". With --base it
    unlearns them."""
    preset: Annotated[str, one_of(PRESETS)] = "full"
    """How much to train; "smoke" only checks that training works."""
    base: Annotated[Path | None, arg(metavar="FILE")] = None
    """Checkpoint to fine-tune; the default is to train from scratch."""
    steps: Annotated[int | None, at_least(1, MOST_STEPS)] = None
    """Steps of the optimiser; the default is the preset's."""
    seed: Annotated[int, at_least(0, MOST_SEED)] = 0
    """Seed of all random numbers."""
    threads: Annotated[int, at_least(1, MOST_WORKERS)] = 1
    """Number of CPU threads of torch."""
    bfloat16: bool = False
    """Multiply matrices in bfloat16: 1.5 times as fast on processors with instructions for it, many
    times slower on others."""
    device: Annotated[str, one_of(DEVICES)] = "cpu"
    """Where to train."""
    out: Path | None = None
    """Folder for the checkpoint, TensorBoard's curves, and the state to continue from; the default
    is in runs, with the learner's name."""

    def execute(self) -> int:
        """Train and report; return 0."""
        if self.wordless and self.learner != "controller":
            raise BadInputError("--wordless is only for `calot train controller`")
        if self.device != "cpu" and self.learner == "planner":
            raise BadInputError(f"--device {self.device}: `calot train planner` allows cpu")
        if not self.data:
            raise BadInputError("--data: name a folder")
        out = self.out or Path("runs") / self.learner
        require_writable_folder(out, "--out")
        with claimed(out, "--out"):
            return self._train(out)

    def _train(self, out: Path) -> int:
        os.environ["OMP_NUM_THREADS"] = str(self.threads)  # read when torch is imported
        import torch

        if self.device == "cuda" and not torch.cuda.is_available():
            raise BadInputError(
                "--device cuda: torch finds no CUDA device; use --device cpu, or see `calot doctor`"
            )
        if self.bfloat16 and self.device == "cpu" and not torch.cpu._is_avx512_bf16_supported():
            Terminal(stderr=True).print(SLOW_BFLOAT16, soft_wrap=True)
        torch.set_num_threads(self.threads)
        with refusing(ValueError):
            checkpoint = getattr(self, f"_{self.learner}")(out)
        Terminal().print(f"checkpoint: {checkpoint}", soft_wrap=True)
        return 0

    def _controller(self, out: Path) -> Path:
        from controller.diffusion import training
        from controller.diffusion.demonstrations import demonstrations

        config, base = self._scheduled(training)
        wordless = self.wordless or config.policy.wordless
        config = replace(config, policy=replace(config.policy, wordless=wordless))
        return self._trained(
            training, lambda: demonstrations(self.data, self._choice()), config, out, base
        )

    def _pixels(self, out: Path) -> Path:
        from controller.pixels import training
        from controller.pixels.films import films

        config, base = self._scheduled(training)
        return self._trained(
            training, lambda: films(self.data, config.policy, self._choice()), config, out, base
        )

    def _planner(self, out: Path) -> Path:
        from controller.dataset.rollouts import rollouts
        from planner.learned import training

        config, base = self._scheduled(training)
        return self._trained(
            training, lambda: rollouts(self.data, self._choice()), config, out, base
        )

    def _perception(self, out: Path) -> Path:
        from controller.perception import training

        if self.leave_out or self.share != 1.0:
            raise BadInputError("--leave-out and --share are not for `calot train perception`")
        config, base = self._scheduled(training)
        files = sorted(path for folder in self.data for path in folder.glob("*.npz"))
        if not files:
            raise BadInputError(
                f"--data {' '.join(map(str, self.data))}: no pictures; `calot collect --pictures`"
                " takes some"
            )
        for view in training.VIEWS:
            Terminal(stderr=True).print(f"view {view}")
            steps = training.train_view(files, view, config, out / view, self.device, base)
            _show(steps, config.steps)
        return training.join_views(files, config, out, base)

    def _trained(
        self,
        training: ModuleType,
        read: Callable[[], Sequence],
        config: Schedule,
        out: Path,
        base: Any,
    ) -> Path:
        reading = Text(visible(f"reading {', '.join(map(str, self.data))}"))
        with Terminal(stderr=True).status(reading):
            dataset = read()
        _show(training.train(dataset, config, out, self.device, base), config.steps)
        return out / training.CHECKPOINT_FILE

    def _choice(self) -> Choice:
        return Choice(leave_out=self.leave_out, share=self.share)

    def _scheduled(self, training: ModuleType) -> tuple[Any, Any]:
        """Return the settings of a training, and the model to fine-tune; None for none."""
        from planner.learning.optimise import fine_tuning

        preset = training.PRESETS[self.preset]
        steps = self.steps or preset.steps
        config = replace(preset, seed=self.seed, steps=steps, bfloat16=self.bfloat16)
        return fine_tuning(training.CHECKPOINTS, config, self.base) if self.base else (config, None)


def _show(steps: Iterable[TrainingStep], total: int) -> None:
    loss = TextColumn("loss {task.fields[loss]:.4f}")
    columns = (
        TextColumn("training"),
        BarColumn(),
        MofNCompleteColumn(),
        loss,
        TimeRemainingColumn(),
    )
    console, coming = Terminal(stderr=True), iter(steps)
    if (first := next(coming, None)) is None:
        console.print(f"trained before: {total} of {total} steps")
        return
    with Progress(*columns, console=console) as progress:
        task = progress.add_task("training", total=total, loss=float("nan"))
        for step in chain([first], coming):
            progress.update(task, completed=step.step, loss=step.loss)
