"""Laws of the figures of perception."""

import numpy as np
import pytest

from scenarios.bench.perception import MAX_CLIPS, N_POINTS, Moment, correlation, figures


def looks(error_m: np.ndarray, std_m: float = 0.001) -> list[Moment]:
    """Return looks with these errors (n, `N_POINTS`, 3), without clips."""
    there = np.arange(N_POINTS) < N_POINTS - MAX_CLIPS
    return [
        Moment(
            error_m=error,
            there=there,
            near=there,
            tip_error_m=np.array([0.001, 0.0, 0.0]),
            off_line_m=np.zeros((2, 8)),
            std_m=np.full(N_POINTS, std_m),
            hidden=np.zeros(N_POINTS, bool),
            counted=True,
            cut_seen=k % 2 == 0,
            cpu_s=0.03,
        )
        for k, error in enumerate(error_m)
    ]


def test_an_error_like_the_tips_is_none_from_where_the_tip_is_believed():
    error_m = np.tile([0.001, 0.0, 0.0], (10, N_POINTS, 1))
    said = figures(looks(error_m))
    assert said["tubes near the tip, median"] == pytest.approx(1.0)
    assert said["tubes near the tip, from where it is believed, p90"] == pytest.approx(0.0)
    assert said["cuts seen right"] == 0.5
    assert said["ms a look"] == pytest.approx(30.0)


def test_ellipses_hold_as_many_normal_errors_as_they_say():
    error_m = 0.001 * np.random.default_rng(0).standard_normal((300, N_POINTS, 3))
    assert figures(looks(error_m))["tubes, in the 95 % ellipse"] == pytest.approx(0.95, abs=0.01)


def test_the_parts_of_an_error_are_found_again():
    rng, n = np.random.default_rng(0), 3000
    slow, kept = np.zeros((n, N_POINTS, 3)), np.exp(-1 / 20)
    for k in range(1, n):
        slow[k] = kept * slow[k - 1] + np.sqrt(1 - kept**2) * rng.standard_normal((N_POINTS, 3))
    constant = 0.5 * rng.standard_normal((N_POINTS, 3))
    white = 0.3 * rng.standard_normal(slow.shape)
    said = correlation(looks(1e-3 * (constant + slow + white)))
    assert said["constant"] == pytest.approx(np.sqrt((constant[:16] ** 2).mean()), abs=0.05)
    assert said["slow"] == pytest.approx(1.0, abs=0.1)
    assert said["slow for looks"] == pytest.approx(20, abs=4)
    assert said["white"] == pytest.approx(0.3, abs=0.1)
