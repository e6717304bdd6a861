"""Laws of what a robot with cameras has in a control step; they need a renderer."""

import numpy as np
import pytest

from tissue_sim.frames import inverse_pose, transform
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.rendering.renderer import renderer_available
from tissue_sim.rendering.shader_pack import COLOR_PICTURE, POSITION_PICTURE
from tissue_sim.sensing.cameras import T_world_camera
from tissue_sim.sensing.exact import exact_observation
from tissue_sim.sensing.eyes import (
    CLOSE,
    ENDOSCOPE_VIEWS,
    JAW_PLAY_RAD,
    USUAL,
    VIEWS,
    WHOLE,
    Eyes,
)
from tissue_sim.sensing.glance import Glance
from tissue_sim.sensing.observation import N_LINE, N_SHOWN
from tissue_sim.sensing.picture_points import project, shown_points, visible
from tissue_sim.tools.arms import JointCommand
from tissue_sim.world import World

pytestmark = [
    pytest.mark.render,
    pytest.mark.skipif(not renderer_available(), reason="SAPIEN finds no Vulkan renderer here"),
]
FAULTLESS = USUAL.scaled(0.0)
AIM_M = np.array([0.004, -0.003, 0.09])


@pytest.fixture(scope="module")
def world() -> World:
    world = World(render=True)
    world.reset(textbook_from_seed(3))
    return world


def glances(
    world: World, model=USUAL, n: int = 1, every: int = 1, aim_m=None, views=VIEWS
) -> list[Glance]:
    assert world.view is not None
    eyes = Eyes(np.random.default_rng(0), model, every, views=views)
    return [eyes.glance(world, world.view, world.observe(), aim_m) for _ in range(n)]


def test_pictures_come_in_the_steps_in_which_it_looks(world: World):
    assert [bool(g.pictures) for g in glances(world, n=5, every=2)] == [1, 0, 1, 0, 1]


def test_a_picture_has_its_views_size_and_focal_length(world: World):
    both = glances(world, n=2, aim_m=AIM_M)
    pictures = both[0].pictures | both[1].pictures
    for spec in VIEWS:
        picture = pictures[spec.name]
        assert picture.rgb.shape == (spec.height, spec.width, 3)
        assert picture.focal_px == spec.focal_px
        assert picture.rgb.std() > 10


def test_without_the_wrists_the_endoscope_shows_the_same(world: World):
    those = [glances(world, n=2, aim_m=AIM_M, views=views) for views in (ENDOSCOPE_VIEWS, VIEWS)]
    for name, (alone, among) in zip((WHOLE, CLOSE), zip(*those, strict=True), strict=True):
        assert set(alone.pictures) == {name} < set(among.pictures)
        assert (alone.pictures[name].rgb == among.pictures[name].rgb).all()


def test_the_endoscope_shows_the_whole_and_what_it_is_aimed_at_by_turns(world: World):
    looks = [set(g.pictures) & {WHOLE, CLOSE} for g in glances(world, n=4, aim_m=AIM_M)]
    assert looks == [{WHOLE}, {CLOSE}, {WHOLE}, {CLOSE}]
    assert all(CLOSE not in g.pictures for g in glances(world, n=2))  # with nothing to aim at
    close = glances(world, n=2, aim_m=AIM_M)[1].pictures[CLOSE]
    assert close.project(AIM_M[None])[0][0] == pytest.approx([80, 60], abs=1e-6)
    assert close.T_endoscope_camera[:3, 3] == pytest.approx(np.zeros(3), abs=1e-9)  # the same eye


def test_both_crops_have_the_right_tip_in_their_middle(world: World):
    (glance,) = glances(world)
    tip = glance.tips_endoscope[1, :3, 3][None]
    right = glance.pictures["wrist_right_tip"].project(tip)[0][0]
    assert right == pytest.approx([64, 64], abs=3)  # the hand-eye error moves tip and camera alike
    left = glance.pictures["wrist_left_tip"].project(tip)[0][0]
    assert left == pytest.approx([64, 64], abs=25)  # not that of two arms


def test_without_errors_the_robot_is_told_the_truth(world: World):
    (glance,) = glances(world, FAULTLESS)
    exact = exact_observation(world)
    assert glance.tips_endoscope == pytest.approx(exact.tips_endoscope)
    assert glance.forces_n == pytest.approx(exact.forces_n)
    to_endoscope = inverse_pose(world.T_world_endoscope)
    for name, picture in glance.pictures.items():
        assert picture.T_endoscope_camera == pytest.approx(
            to_endoscope @ T_world_camera(world, name)
        )


def test_labels_and_a_glance_project_alike(world: World):
    both = glances(world, FAULTLESS, n=2, aim_m=AIM_M)
    pictures = both[0].pictures | both[1].pictures
    points, *_ = shown_points(world, exact_observation(world))
    aims_m = {CLOSE: transform(world.T_world_endoscope, AIM_M)}
    for spec in VIEWS:
        T_world_eye = T_world_camera(world, spec.name, aims_m.get(spec.name))
        pixels, ahead = project(spec, T_world_eye, points)
        seen = transform(inverse_pose(world.T_world_endoscope), points)
        there, away = pictures[spec.name].project(seen)
        assert away == pytest.approx(ahead)
        assert there[ahead > 0.005] == pytest.approx(pixels[ahead > 0.005])


def test_the_endoscope_shows_the_tubes_at_rest_and_nothing_that_is_not_there(world: World):
    assert world.view is not None
    spec = VIEWS[0]
    taken = world.view.pictures(world, VIEWS[:1], (COLOR_PICTURE, POSITION_PICTURE))
    points, there, depths = shown_points(world, exact_observation(world))
    assert len(points) == len(there) == N_SHOWN
    pixels, ahead = project(spec, T_world_camera(world, spec.name), points)
    shown = there & visible(pixels, ahead, depths, taken[POSITION_PICTURE][spec.name])
    assert shown[:16].mean() > 0.8
    assert not shown[N_LINE:].any()
    behind = points - 0.05 * world.T_world_endoscope[:3, 2]
    pixels, ahead = project(spec, T_world_camera(world, spec.name), behind)
    assert not visible(pixels, ahead, depths, taken[POSITION_PICTURE][spec.name])[:16].any()


def test_a_jaws_encoder_lags_by_no_more_than_its_play(world: World):
    assert world.view is not None
    eyes, off = Eyes(np.random.default_rng(0), FAULTLESS, every=1000), []
    for k in range(20):
        joints = world.arms.joints
        joints[:, 6] = 0.3 + 0.2 * np.sin(0.5 * k)
        told = world.step(JointCommand(joints=joints))
        off.append(eyes.glance(world, world.view, told).joints[:, 6] - world.arms.joints[:, 6])
    assert 0.0 < np.abs(off).max() <= 0.5 * JAW_PLAY_RAD + 1e-9
