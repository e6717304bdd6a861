"""A law of every training: stopped and taken up again, it ends where it would have ended."""

from __future__ import annotations

from collections.abc import Callable, Generator
from itertools import islice
from pathlib import Path

import torch

from planner.learning.optimise import TrainingStep


def goes_on_where_it_stopped(
    train: Callable[[Path], Generator[TrainingStep]],
    weights: Callable[[Path], dict[str, torch.Tensor]],
    whole: tuple[Path, list[TrainingStep]],
    again: Path,
    save_every: int,
) -> bool:
    """Whether a training broken off in the folder `again` goes on just as the whole one went."""
    out, steps = whole
    interrupted = train(again)
    _ = list(islice(interrupted, save_every + 7))  # 7 steps are lost
    interrupted.close()
    same_steps = list(train(again)) == steps[save_every:]
    expected, found = weights(out), weights(again)
    return same_steps and all(torch.equal(w, expected[name]) for name, w in found.items())
