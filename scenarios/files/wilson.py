"""The confidence interval of a pass rate."""

import math


def wilson_interval(passed: int, n: int, z: float = 1.96) -> tuple[float, float]:
    """Return the score interval of Wilson (1927, J. Am. Stat. Assoc. 22:209-212, eq. 2).

    Its ends are the two rates p that solve (passed/n - p)^2 = z^2 p (1 - p) / n.

    Args:
        passed: Number of successes, 0 to n.
        n: Number of trials; for 0 the interval is (0, 1).
        z: Normal quantile; 1.96 for 95 %.

    Raises:
        ValueError: `passed` is not within 0 and n.
    """
    if not 0 <= passed <= n:
        raise ValueError(f"passed must be 0 to n = {n}, got {passed}")
    if n == 0:
        return 0.0, 1.0
    rate, z2 = passed / n, z * z
    centre = rate + z2 / (2 * n)
    half_width = z * math.sqrt(rate * (1 - rate) / n + z2 / (4 * n * n))
    scale = 1 + z2 / n
    return max(0.0, (centre - half_width) / scale), min(1.0, (centre + half_width) / scale)
