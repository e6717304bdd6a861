"""Train the alarm head: `python -m planner.language.train_alarm SET.tsv ...`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from planner.language.alarm_head import features, fit, save
from planner.language.sentence_sets import holds
from tissue_sim.frames import Array


def trained(paths: Sequence[Path]) -> Array:
    """Return the weights (385,) for the sentences of sets."""
    lines = [line for path in paths for line in path.read_text("utf-8").splitlines()[1:]]
    said = [line.split("\t") for line in lines]
    rows = np.stack([features(sentence) for sentence, _ in said])
    return fit(rows, np.array([holds(expected) for _, expected in said], float))


if __name__ == "__main__":
    save(trained([Path(name) for name in sys.argv[1:]]))
