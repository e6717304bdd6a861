"""`calot train`: learn from demonstrations."""

import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from tyro.conf import Positional, arg

from scenarios.commands.arguments import at_least, one_of
from scenarios.commands.output_path import require_writable_folder
from scenarios.demonstration.mix import KINDS
from scenarios.errors import BadInputError

LEARNERS = ("controller",)
PRESETS = ("full", "smoke")
DEVICES = ("cpu", "cuda")


@dataclass(frozen=True, kw_only=True)
class Train:
    """Learn from demonstrations; the same call again goes on where it was stopped."""

    learner: Positional[Annotated[str, one_of(LEARNERS)]]
    """What learns: the diffusion controller."""
    data: Path = Path("runs/demonstrations")
    """Folder of demonstrations, as `calot collect` leaves it."""
    leave_out: Annotated[str | None, one_of(KINDS)] = None
    """Demonstrations of this kind, to see what they are good for."""
    preset: Annotated[str, one_of(PRESETS)] = "full"
    """How much: "smoke" only shows that it learns."""
    base: Annotated[Path | None, arg(metavar="FILE")] = None
    """Checkpoint to go on from, more gently; left out, training begins anew."""
    steps: Annotated[int | None, at_least(1)] = None
    """Of the optimiser; left out, the preset's."""
    seed: Annotated[int, at_least(0)] = 0
    """Of everything random."""
    threads: Annotated[int, at_least(1)] = 1
    """For torch, on the CPU."""
    bfloat16: bool = False
    """Multiply matrices in it: half again as fast where the processor can (AVX-512 BF16)."""
    device: Annotated[str, one_of(DEVICES)] = "cpu"
    """Where to train."""
    out: Path = Path("runs/controller")
    """Folder for policy.safetensors, TensorBoard's curves, and what going on needs."""

    def execute(self) -> int:
        """Trains and reports; returns 0."""
        require_writable_folder(self.out, "--out")
        os.environ["OMP_NUM_THREADS"] = str(self.threads)  # read when torch is imported
        os.environ["OMP_WAIT_POLICY"] = "passive"  # else a core lost to others halts all threads
        import torch

        from controller.diffusion import training
        from controller.diffusion.demonstrations import demonstrations

        if self.device == "cuda" and not torch.cuda.is_available():
            raise BadInputError("--device cuda: there is none; see `calot doctor`")
        torch.set_num_threads(self.threads)
        preset = training.PRESETS[self.preset]
        config = replace(
            preset,
            seed=self.seed,
            steps=self.steps or preset.steps,
            bfloat16=self.bfloat16,
        )
        base, console = None, Console(stderr=True)
        try:
            if self.base:
                config, base = training.fine_tuning(config, self.base)
            with console.status(f"reading {self.data}"):
                learnt_from = demonstrations(self.data, self.leave_out)
            steps = training.train(learnt_from, config, self.out, self.device, base)
            _show(steps, config.steps, console)
        except ValueError as error:
            raise BadInputError(str(error)) from None
        Console().print(f"checkpoint: {self.out / training.CHECKPOINT_FILE}", soft_wrap=True)
        return 0


def _show(steps, total: int, console: Console) -> None:
    loss = TextColumn("loss {task.fields[loss]:.4f}")
    columns = (
        TextColumn("training"),
        BarColumn(),
        MofNCompleteColumn(),
        loss,
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console) as progress:
        task = progress.add_task("training", total=total, loss=float("nan"))
        for step in steps:
            progress.update(task, completed=step.step, loss=step.loss)
