"""Does a sentence that nothing else understands warn? A linear head on the sentence encoder tells.

The words of warnings.toml cannot name every fright. Of the warnings of the development sets that
the head was not trained on it hears about three in four, and one in three sentences that are no
business of the robot's it takes for one, which costs a second; most of those are small talk, which
a rule keeps from it.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
from safetensors.numpy import load_file
from safetensors.numpy import save as to_bytes

from planner.language.phrases import normalised
from planner.language.sentence_encoder import embed
from planner.learning.atomic_write import write_atomic
from tissue_sim.frames import Array

SHIPPED = Path(__file__).with_name("alarm_head.safetensors")
# Probability from which the arms hold, and that where a command is guessed. Chosen on the
# development sets: a warning that is missed may injure, one that is heard in vain costs a second.
ALARMED, GUESSED = 0.25, 0.5
PENALTY, STEPS = 0.3, 25  # on the squared weights; of Newton's method


def alarms(text: str, *, guessed: bool = False) -> bool:
    """Return whether a text is taken for a warning, by its meaning.

    Args:
        text: in English.
        guessed: it may mean a command, "cut that one", and is asked back otherwise.
    """
    return bool(chance(features(text), _weights()) > (GUESSED if guessed else ALARMED))


def features(text: str) -> Array:
    """Return the features (385,) of a text: its embedding and a one."""
    return np.append(embed(normalised(text)).numpy().astype(float), 1.0)


def chance(rows: Array, weights: Array) -> Array:
    """Return the probability that rows (..., 385) of features are of warnings."""
    return 1.0 / (1.0 + np.exp(-rows @ weights))


def fit(rows: Array, warns: Array) -> Array:
    """Return the weights (385,) of a logistic regression on rows (n, 385) and labels (n,)."""
    weights = np.zeros(rows.shape[1])
    penalty = PENALTY * np.append(np.ones(rows.shape[1] - 1), 1e-6)
    for _ in range(STEPS):
        p = chance(rows, weights)
        slope = rows.T @ (p - warns) + penalty * weights
        curvature = (rows.T * (p * (1.0 - p))) @ rows + np.diag(penalty)
        weights = weights - np.linalg.solve(curvature, slope)
    return weights


def save(weights: Array, path: Path = SHIPPED) -> None:
    """Write weights (385,)."""
    write_atomic(path, to_bytes({"weights": weights.astype(np.float32)}))


@cache
def _weights() -> Array:
    return load_file(SHIPPED)["weights"].astype(float)
