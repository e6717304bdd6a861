"""Train the alarm head: `python -m planner.language.train_alarm SET.tsv ...`."""

from __future__ import annotations

import sys
from collections.abc import Sequence

import numpy as np

from planner.language.alarm_head import features, fit, save
from planner.language.sentence_sets import Row, holds, keeps_the_protocol, rows_named
from tissue_sim.frames import Array


def trained(rows: Sequence[Row]) -> Array:
    """Return the weights (385,) for the sentences of sets that keep the protocol."""
    inputs = np.stack([features(row.said) for row in rows])
    return fit(inputs, np.array([holds(row.expected) for row in rows], float))


if __name__ == "__main__":
    save(trained(rows_named(sys.argv[1:], "planner.language.train_alarm", keeps_the_protocol)))
