"""Laws of the radii: they follow from how wide structures appear and how far they are."""

import numpy as np
import pytest

from controller.perception.network import N_WIDE
from controller.perception.radii import Radii
from tests.controller.perception.ideal_views import EYES, prior, shown
from tissue_sim.sensing.observation import N_LINE, TUBE_POINTS

LOOKS = 40
TUBES_M = [0.0012, 0.0031, 0.0009]
TRUE_M = np.concatenate([np.repeat(TUBES_M, TUBE_POINTS), np.linspace(0.006, 0.012, 5)])


def looked(*, visible: bool = True, error: float = 0.0, looks: int = LOOKS) -> Radii:
    """Return what is believed after looks at points whose radii appear larger by a share."""
    rng, radii = np.random.default_rng(0), Radii(prior())
    points = prior().mean.reshape(N_LINE, 3)
    for _ in range(looks):
        views = {}
        for name, picture in EYES.items():
            _, ahead = picture.project(points[:N_WIDE])
            log_radius = np.zeros(N_LINE)
            log_radius[:N_WIDE] = np.log(picture.focal_px * TRUE_M / ahead) + error
            views[name] = shown(picture, points, rng)._replace(
                log_radius=log_radius + 0.1 * rng.standard_normal(N_LINE),
                visible=np.full(N_LINE, 5.0 if visible else -5.0),
            )
        radii.look(EYES, views, points)
    return radii


def test_radii_of_all_tubes_and_of_the_gallbladder_are_found():
    radii = looked()
    assert radii.tubes_m == pytest.approx(TUBES_M, rel=0.05)
    assert radii.sac_m == pytest.approx(np.linspace(0.006, 0.012, 5), rel=0.1)


def test_what_is_hidden_keeps_what_patients_have_on_average():
    radii = looked(visible=False)
    assert radii.tubes_m == pytest.approx(prior().radius_m)
    assert radii.sac_m == pytest.approx(prior().sac_radius_m)


def test_one_look_counts_little_and_many_looks_do_not_settle_for_ever():
    once, often = looked(looks=1), looked(looks=LOOKS)
    assert abs(np.log(once.tubes_m[0] / 0.0012)) > abs(np.log(often.tubes_m[0] / 0.0012))
    for _ in range(20):
        views = {
            name: shown(
                picture, prior().mean.reshape(N_LINE, 3), np.random.default_rng(1)
            )._replace(
                log_radius=np.full(N_LINE, np.log(300.0 * 0.004 / 0.1)),
            )
            for name, picture in {"ahead": EYES["ahead"]}.items()
        }
        often.look({"ahead": EYES["ahead"]}, views, prior().mean.reshape(N_LINE, 3))
    assert often.tubes_m[0] > 0.0013
