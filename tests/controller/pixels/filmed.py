"""Made-up films for tests: a bright spot on a dark picture is where the tip must go."""

import numpy as np

from controller.pixels.films import Film
from tests.controller.diffusion.demonstrated import demonstration

HEIGHT, WIDTH = 30, 40


def film(seed: int = 0, n: int = 120) -> Film:
    """Return a film of a demonstration, by one camera."""
    shown = demonstration(n, seed)
    chance = np.random.default_rng(seed)
    pictures = np.zeros((len(shown.task), 1, HEIGHT, WIDTH, 3), np.uint8)
    rows, columns = (
        chance.integers(0, HEIGHT, len(pictures)),
        chance.integers(0, WIDTH, len(pictures)),
    )
    pictures[np.arange(len(pictures)), 0, rows, columns] = 255
    shown.actions[:, 10] = 1e-4 * (columns - WIDTH / 2)
    shown.actions[:, 11] = 1e-4 * (rows - HEIGHT / 2)
    return Film(demonstration=shown, pictures=pictures)
