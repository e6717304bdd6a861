"""Collecting labelled pictures for `calot collect --pictures`."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console

from scenarios.commands.options.renderer_option import require_renderer
from scenarios.demonstration.mix import TRAINING_SEEDS
from scenarios.demonstration.pictures import frames_path, picture, pictured
from scenarios.files.errors import BadInputError
from scenarios.loop.progress import ProgressDisplay


def collect_pictures(first_seed: int, episodes: int, out: Path, checkpoint: str = "") -> int:
    """Take the missing labelled pictures, and report; return the exit code.

    Raises:
        BadInputError: there is no renderer, too few training seeds are left, or the disk is full.
    """
    require_renderer("--pictures")
    asked = pictured(first_seed, episodes, checkpoint)
    if len(asked) < episodes:
        raise BadInputError(
            f"--seed {first_seed} --episodes {episodes}: only {len(asked)} seeds are left;"
            f" pictures are of training seeds, 0 to {TRAINING_SEEDS.stop - 1}"
        )
    waiting = [d for d in asked if not frames_path(d, out).exists()]
    frames = 0
    with ProgressDisplay(len(waiting), Console(stderr=True)) as display:
        for demonstration in waiting:
            try:
                frames += picture(demonstration, out)
            except OSError as error:
                raise BadInputError(
                    f"--out: cannot write in {out} ({error.strerror}); finished episodes are"
                    " complete: free some space and call again"
                ) from None
            display.advance()
    Console().print(
        f"pictures: {out}, {len(asked)} episodes, of them {len(waiting)} new with {frames} frames",
        soft_wrap=True,
    )
    return 0
