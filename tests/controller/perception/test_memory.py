"""Laws of the memory of clips and cuts."""

from dataclasses import replace

import numpy as np
import pytest

from controller.perception.clips import Clips, tube_m
from controller.perception.cuts import Cuts
from controller.perception.fusion import Lines
from controller.perception.graph import Shown
from controller.perception.prior import Prior
from tests.tissue_sim.kinds import POLYMER
from tissue_sim.frames import Array, pose
from tissue_sim.sensing.glance import Glance, Picture
from tissue_sim.sensing.observation import N_LINE
from tissue_sim.sensing.polyline import nearest_on, place_on
from tissue_sim.tools.instruments import CLIP_APPLIER, GRASPER, SCISSORS


@pytest.fixture
def lines() -> Lines:
    """Return two straight upright tubes 10 mm apart, seen well."""
    points = np.zeros((N_LINE, 3))
    points[:8, 1] = points[8:16, 1] = np.linspace(0.0, 0.021, 8)
    points[8:, 0], points[16:, 1] = -0.01, 0.05
    n = 3 * N_LINE
    return Lines(
        Prior(
            mean=points.ravel(),
            spread=0.0005**2 * np.eye(n),
            drift=1e-8 * np.eye(n),
            radius_m=np.full(2, 0.002),
            sac_radius_m=np.full(5, 0.01),
        )
    )


def glance(tool: str, at: Array, *, jaw_rad: float = 0.0, loaded: bool = False) -> Glance:
    """Return a step in which the right jaws, square to the tubes, have their middle at a point."""
    joints, tips = np.zeros((2, 7)), np.tile(np.eye(4), (2, 1, 1))
    joints[1, 6] = jaw_rad
    tips[1] = pose(np.eye(3), at + np.array([0.0, 0.0, 0.5 * POLYMER.length_m]))
    return Glance(
        time_s=0.0,
        joints=joints,
        tips_endoscope=tips,
        forces_n=np.zeros((2, 3)),
        pinch_n=0.0,
        tools=(GRASPER, tool),
        clip_loaded=loaded,
        T_world_endoscope=np.eye(4),
        shaft_offset_m=np.zeros(2),
    )


def says(lines: Lines, tube: int, *, ends: bool) -> tuple[dict[str, Picture], dict[str, Shown]]:
    """Return a view from 100 mm in front, and what it says of ends 10 mm up a tube."""
    turned = np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]], float)  # x ahead of the eye
    picture = Picture(
        rgb=np.zeros((128, 128, 3), np.uint8),
        T_endoscope_camera=pose(turned, np.array([0.0, 0.01, -0.1])),
        focal_px=200.0,
    )
    dense = np.full((2, 32, 32), -6.0)
    ((column, row),), _ = picture.project(np.array([[-0.01 * tube, 0.01, 0.0]]))
    dense[1, int(row / 4), int(column / 4)] = 6.0 if ends else -6.0
    known = np.full(N_LINE, 5.0)
    pixels = np.zeros((N_LINE, 2))
    view = Shown(
        pixels=pixels,
        log_sigma=known,
        inside=known,
        visible=known,
        log_radius=known,
        dense=dense,
        offset=np.zeros((2, 2, 32, 32)),
        flags=np.zeros(3),
    )
    return {"view": picture}, {"view": view}


def closed(lines: Lines, at: Array) -> Clips:
    clips = Clips()
    for loaded in (True, False):
        clips.step(glance(CLIP_APPLIER, at, loaded=loaded), lines, 1 / 30)
    return clips


def test_a_closing_of_the_applier_is_a_clip_where_its_jaws_are(lines: Lines):
    at = np.array([-0.01, 0.0075, 0.0])
    clips = closed(lines, at)
    places_m, variance_m2 = clips.places(lines)
    assert len(clips) == 1
    assert places_m[0] == pytest.approx(at, abs=2e-4)
    assert variance_m2[0] > 0.0
    assert not places_m[1:].any()


def test_a_clip_moves_with_its_tube(lines: Lines):
    clips = closed(lines, np.array([0.0, 0.0105, 0.0]))
    before = clips.places(lines)[0][0]
    lines.hold(tube_m(lines, 0)[3] + np.array([0.004, 0.0, 0.0]), (3, 0.5), np.eye(3)[:2], 1e-5)
    assert clips.places(lines)[0][0, 0] - before[0] > 0.001


def test_changing_the_tool_is_no_clip(lines: Lines):
    clips = Clips()
    clips.step(glance(CLIP_APPLIER, np.zeros(3), loaded=True), lines, 1 / 30)
    clips.step(glance(SCISSORS, np.zeros(3), loaded=False), lines, 1 / 30)
    assert len(clips) == 0


def test_a_clip_that_closes_on_nothing_is_counted_and_lies_there(lines: Lines):
    at = np.array([0.03, 0.0, 0.02])
    clips = closed(lines, at)
    assert len(clips) == 1
    assert clips.places(lines)[0][0] == pytest.approx(at)


def test_scissors_that_close_on_a_tube_sever_it(lines: Lines):
    cuts, at = Cuts(), np.array([-0.01, 0.01, 0.0])
    for jaw_rad in (0.5, 0.0):
        cuts.step(glance(SCISSORS, at, jaw_rad=jaw_rad), lines)
    assert cuts.severed.tolist() == [False, True]


def test_scissors_that_close_elsewhere_or_were_never_open_sever_nothing(lines: Lines):
    cuts = Cuts()
    for jaw_rad in (0.5, 0.0):
        cuts.step(glance(SCISSORS, np.array([0.03, 0.01, 0.0]), jaw_rad=jaw_rad), lines)
    cuts.step(glance(SCISSORS, np.array([0.0, 0.01, 0.0])), lines)
    assert not cuts.severed.any()


@pytest.mark.parametrize("tube", [0, 1])
@pytest.mark.parametrize("ends", [True, False])
def test_pictures_refute_a_cut_that_failed_and_confirm_one_that_did_not(
    lines: Lines, tube: int, ends: bool
):
    cuts = Cuts()
    for jaw_rad in (0.5, 0.0):
        cuts.step(glance(SCISSORS, np.array([-0.01 * tube, 0.01, 0.0]), jaw_rad=jaw_rad), lines)
    assert cuts.severed[tube]
    for _ in range(110):  # 11 s
        cuts.look(*says(lines, tube, ends=ends), lines)
    assert cuts.severed[tube] == ends
    assert not cuts.severed[1 - tube]


def test_a_cut_that_is_confirmed_is_not_forgotten(lines: Lines):
    cuts = Cuts()
    for jaw_rad in (0.5, 0.0):
        cuts.step(glance(SCISSORS, np.array([0.0, 0.01, 0.0]), jaw_rad=jaw_rad), lines)
    for ends in (*[True] * 20, *[False] * 200):
        cuts.look(*says(lines, 0, ends=ends), lines)
    assert cuts.severed[0]


def test_pictures_alone_sever_nothing(lines: Lines):
    cuts = Cuts()
    for _ in range(100):
        cuts.look(*says(lines, 0, ends=True), lines)
    assert not cuts.severed.any()


def test_a_place_on_a_line_is_found_again(lines: Lines):
    line = tube_m(lines, 0)
    k, share, away = nearest_on(line, place_on(line, 4.25) + np.array([0.001, 0.0, 0.0]))
    assert (k + share, away) == (pytest.approx(4.25), pytest.approx(0.001))


def test_beside_a_cut_a_line_goes_on_from_its_own_side(lines: Lines):
    line = tube_m(lines, 0).copy()
    line[4:] += np.array([0.02, 0.0, 0.0])  # the upper stump has moved away
    assert place_on(line, 3.4, cut=3.5) == pytest.approx(np.array([0.0, 0.0102, 0.0]))
    assert place_on(line, 3.6, cut=3.5) == pytest.approx(np.array([0.02, 0.0108, 0.0]))
    assert place_on(line, 1.5, cut=3.5) == pytest.approx(place_on(line, 1.5))


def test_a_glance_holds_nothing_of_the_tissue():
    assert not any("tube" in name or "clips" in name for name in vars(glance(GRASPER, np.zeros(3))))
    assert replace(glance(GRASPER, np.zeros(3)), time_s=1.0).pictures == {}


@pytest.mark.parametrize("ends", [True, False])
def test_blades_that_have_nearly_closed_sever_only_what_pictures_confirm(lines: Lines, ends: bool):
    cuts = Cuts()
    for jaw_rad in (0.5, 0.122, 0.5):
        cuts.step(glance(SCISSORS, np.array([0.0, 0.01, 0.0]), jaw_rad=jaw_rad), lines)
    assert not cuts.severed.any()
    for _ in range(3):
        cuts.look(*says(lines, 0, ends=ends), lines)
    assert cuts.severed.tolist() == [ends, False]
