"""Collect labelled pictures for `calot collect --pictures`."""

from __future__ import annotations

from pathlib import Path

from scenarios.commands.collected import broken_lines, written_or_refused
from scenarios.commands.options.renderer_option import require_renderer
from scenarios.demonstration.alike import require_pictures_alike
from scenarios.demonstration.demonstrate import DemonstrationOutcome
from scenarios.demonstration.mix import TRAINING_SEEDS
from scenarios.demonstration.pictures import frames_path, picture, pictured
from scenarios.files.errors import BadInputError
from scenarios.files.exit_codes import ERROR
from scenarios.files.outside_text import Terminal
from scenarios.loop.progress import ProgressDisplay


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
    outcomes: list[DemonstrationOutcome] = []
    waiting = [d for d in asked if not frames_path(d, out).exists()]
    with ProgressDisplay(len(waiting), Terminal(stderr=True)) as display:
        for demonstration in waiting:
            outcomes.append(written_or_refused(picture(demonstration, out)))
            display.advance()
    broken = broken_lines(outcomes)
    frames = sum(outcome.frames for outcome in outcomes)
    there, new = len(asked) - len(broken), len(waiting) - len(broken)
    line = f"pictures: {out}, {there} episodes, of them {new} new with {frames} frames"
    for told in (*broken, line):
        Terminal().print(told, highlight=False, markup=False, soft_wrap=True)
    return ERROR if broken else 0
