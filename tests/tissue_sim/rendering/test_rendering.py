"""Tests of the cameras' pictures; they need a renderer."""

from dataclasses import replace

import gymnasium as gym
import numpy as np
import pytest
from scipy.ndimage import uniform_filter

from tests.tissue_sim.kinds import POLYMER
from tissue_sim import environment
from tissue_sim.frames import AWAY, RIGHT, UP, Array, inverse_pose, pose, transform, unit
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.patient.walls import n_patches, patch_corners
from tissue_sim.rendering.renderer import renderer_available
from tissue_sim.sensing.cameras import BASELINE_M, CameraSpec, T_world_camera
from tissue_sim.sensing.glance import CAMERA_NAMES
from tissue_sim.surgery.clip import detach, latch
from tissue_sim.surgery.cut import sever
from tissue_sim.surgery.leak import leaks
from tissue_sim.tools.arms import JointCommand
from tissue_sim.world import World

pytestmark = [
    pytest.mark.render,
    pytest.mark.skipif(not renderer_available(), reason="SAPIEN finds no Vulkan renderer here"),
]
SEED = 3


@pytest.fixture(scope="module")
def seen() -> World:
    """Return one world with cameras, for tests that reset it."""
    return World(render=True)


@pytest.fixture
def world(seen: World) -> World:
    seen.reset(textbook_from_seed(SEED))
    return seen


def across(world: World, tube: str, share: float) -> Array:
    """Return `T_world_tool` of closed jaws square across a tube, on the endoscope's side."""
    point, along = world.tubes.point(tube, share * world.tubes.length_m[tube])
    forward = unit(AWAY - (AWAY @ along) * along)
    axes = np.stack([along, np.cross(forward, along), forward], axis=1)
    return pose(axes, point + (world.tubes.radius_m(tube) + 0.0015) * forward)


def clip_on(world: World, tube: str, share: float) -> None:
    clip = latch(world.tubes, across(world, tube, share), POLYMER, number=1, time_s=0.0)
    assert not clip.lost
    world.record = replace(world.record, clips=(*world.record.clips, clip))


def hold(world: World, steps: int) -> None:
    for _ in range(steps):
        world.step(JointCommand(joints=world.arms.joints))


def reach(k: int) -> JointCommand:
    """Move the grasper onto the tissue and work the other jaws, with the arms apart."""
    q = np.array([[0.05, 0.05, 0.10, 0.1, 0.0, 0.0, 0.4], [0.1, 0.0, 0.08, 0.0, 0.1, 0.0, 0.5]])
    q[0, 2] += 0.0012 * k
    q[:, 6] *= 0.5 + 0.5 * np.cos(0.3 * k)
    return JointCommand(joints=q)


def pixels(world: World, points: Array, picture: np.ndarray) -> np.ndarray:
    """Return colours (n, 3) where the endoscope's left eye sees points (n, 3) of the world."""
    height, width = picture.shape[:2]
    ahead, left, up = transform(inverse_pose(T_world_camera(world, CAMERA_NAMES[0])), points).T
    focal = 0.5 * height / np.tan(0.5 * CameraSpec(name=CAMERA_NAMES[0]).fov_rad)
    column = np.round(0.5 * width - focal * left / ahead).astype(int)
    row = np.round(0.5 * height - focal * up / ahead).astype(int)
    return picture[row, column].astype(int)


def test_every_camera_gives_a_bright_and_varied_picture(world: World) -> None:
    for name, picture in world.images(CAMERA_NAMES).items():
        assert picture.shape == (480, 640, 3), name
        assert picture.dtype == np.uint8
        assert picture.mean() > 25
        assert picture.std() > 15
        assert (picture.max(axis=2) < 8).mean() < 0.01  # no large black area


def test_gallbladder_and_tubes_appear_where_they_are_in_their_colours(world: World) -> None:
    picture = world.endoscope_rgb()
    sac = world.tissue.positions()[world.organ.sac_rings[4:-3, 0]].astype(float)
    red, green, blue = np.median(pixels(world, sac, picture), axis=0)
    assert green > red > blue  # bile shows through
    red, green, blue = np.median(
        pixels(world, world.tubes.centres("artery")[3:-3], picture), axis=0
    )
    assert red > 1.5 * max(green, blue)


def test_eyes_are_a_baseline_apart_and_look_the_same_way(world: World) -> None:
    left, right = (T_world_camera(world, f"endoscope_{eye}") for eye in ("left", "right"))
    np.testing.assert_allclose(
        inverse_pose(left) @ right, pose(np.eye(3), np.array([0, -BASELINE_M, 0])), atol=1e-12
    )
    views = world.images(["endoscope_left", "endoscope_right"])
    assert not np.array_equal(*views.values())


def test_wrist_cameras_look_at_the_tips(world: World) -> None:
    for arm, name in enumerate(("wrist_left", "wrist_right")):
        joints = world.arms.joints
        tip = transform(
            inverse_pose(T_world_camera(world, name)), world.arms.T_world_tool()[arm, None, :3, 3]
        )[0]
        assert tip[0] > 0.05, joints
        assert np.linalg.norm(tip[1:]) < 0.12 * tip[0]


def test_picture_follows_the_instruments_and_the_tissue(world: World) -> None:
    before = world.endoscope_rgb()
    assert np.array_equal(before, world.endoscope_rgb())  # nothing moved, nothing changed
    for k in range(20):
        world.step(reach(k))
    assert (np.abs(world.endoscope_rgb().astype(int) - before).max(axis=2) > 30).mean() > 0.02
    calm = world.endoscope_rgb().astype(int)
    world.tissue.positions()[:] += np.array([0.004, 0.0, 0.0], np.float32)
    assert (np.abs(world.endoscope_rgb() - calm).max(axis=2) > 30).mean() > 0.003


def test_rendered_run_is_the_unrendered_run_bit_for_bit(world: World) -> None:
    blind = World()
    blind.reset(textbook_from_seed(SEED))
    for k in range(30):
        world.step(reach(k))
        world.endoscope_rgb()
        blind.step(reach(k))
    assert np.array_equal(world.tissue.positions(), blind.tissue.positions())
    assert np.array_equal(world.arms.joints, blind.arms.joints)
    assert np.array_equal(world.arms.joint_velocities, blind.arms.joint_velocities)


def violet(after: np.ndarray, before: np.ndarray) -> np.ndarray:
    """Return the pixels that became as violet as a clip."""
    return (after[..., 2] > after[..., 1] + 15) & (before[..., 2] <= before[..., 1] + 15)


def test_clip_becomes_visible_and_a_lost_one_lies_elsewhere(world: World) -> None:
    hold(world, 1)
    bare = world.endoscope_rgb().astype(int)
    clip_on(world, "duct", 0.5)
    hold(world, 5)
    clipped = world.endoscope_rgb().astype(int)
    on_tube = violet(clipped, bare)
    assert on_tube.sum() > 30
    (clip,) = world.record.clips
    world.record = replace(world.record, clips=(detach(world.tubes, clip),))
    hold(world, 30)
    off_tube = violet(world.endoscope_rgb().astype(int), bare)
    assert (on_tube & off_tube).sum() < 0.1 * on_tube.sum()
    assert off_tube.sum() > 30


def test_loaded_clip_is_seen_in_the_jaws_and_an_empty_applier_has_none(world: World) -> None:
    loaded = world.endoscope_rgb().astype(int)
    world.record = replace(world.record, clip_loaded=False)
    empty = world.endoscope_rgb().astype(int)
    changed = np.abs(loaded - empty).max(axis=2) > 20
    assert 10 < changed.sum() < 3000


def test_open_stump_shows_its_leak_and_a_red_cut_face(world: World) -> None:
    before = world.endoscope_rgb().astype(int)
    cuts = sever(world.tubes, across(world, "artery", 0.5), time_s=0.0)
    assert len(cuts) == 1
    world.record = replace(
        world.record, cuts=cuts, leaks=leaks(world.tubes, world.record.clips, cuts)
    )
    hold(world, 1)
    after = world.endoscope_rgb().astype(int)
    blood = (
        (after[..., 0] > 60)
        & (after[..., 1] < 0.35 * after[..., 0])
        & (before[..., 1] > 0.4 * before[..., 0])
    )
    assert blood.sum() > 20


def test_a_hole_in_the_gallbladder_is_seen_and_leaks(world: World) -> None:
    before = world.endoscope_rgb().astype(int)
    x, patches = world.tissue.positions(), np.arange(n_patches(world.organ), dtype=np.int32)
    middles = x[patch_corners(world.organ)[:, 1]].mean(axis=1)
    world.sac.open(patches[np.argsort(middles @ AWAY)[:4]])  # nearest to the endoscope
    hold(world, 1)
    assert [leak.structure for leak in world.record.leaks] == ["gallbladder"]
    after = world.endoscope_rgb().astype(int)
    assert (np.abs(after - before).max(axis=2) > 20).sum() > 200


def test_drops_show_the_rate() -> None:
    from tissue_sim.rendering.drawn_leaks import drop_radius_m

    slow, fast = drop_radius_m(1e-8), drop_radius_m(8e-8)
    assert fast == pytest.approx(2.0 * slow)


def test_a_film_holds_what_has_leaked() -> None:
    from tissue_sim.rendering.drawn_leaks import FILM_DEPTH_M, film_radii_m

    volume_m3 = 5e-6
    wide_m, high_m = film_radii_m(volume_m3)
    assert 4.0 / 3.0 * np.pi * wide_m * high_m * 0.5 * FILM_DEPTH_M == pytest.approx(volume_m3)


def test_a_film_runs_down_from_its_opening_over_the_ligament_and_stays(world: World) -> None:
    from tissue_sim.rendering.drawn_leaks import FILM_DEPTH_M, film, leak_surfaces
    from tissue_sim.rendering.drawn_ligament import ligament_depth
    from tissue_sim.surgery.leak import Spill

    before = world.endoscope_rgb().astype(int)
    spill = Spill(structure="artery", place_m=world.tubes.point("artery", 0.002)[0], volume_m3=3e-7)
    world.record = replace(world.record, spilt=(spill,))
    assert not world.record.leaks
    points = film(world, spill).points
    ups = points @ UP
    assert abs(ups.max() - spill.place_m @ UP) < 0.3 * np.ptp(ups)
    depth, _ = ligament_depth(world.organ, points @ RIGHT, ups)
    assert (points @ AWAY <= depth + 1e-9).all()  # before what it lies on
    assert (points @ AWAY).min() > depth.min() - 2.0 * FILM_DEPTH_M
    assert set(leak_surfaces(world)) == {"artery"}
    after = world.endoscope_rgb().astype(int)
    redder = (after[..., 1] < 0.7 * before[..., 1]) & (after[..., 0] > 2 * after[..., 1])
    assert redder.sum() > 300


def test_drawn_clip_embraces_the_tube_it_is_on(world: World) -> None:
    from tissue_sim.surgery.clip import T_world_clip

    clip_on(world, "duct", 0.5)
    hold(world, 10)
    (clip,) = world.record.clips
    T = T_world_clip(world.tubes, clip)
    caught = transform(inverse_pose(T), world.tissue.positions()[list(clip.vertices)].astype(float))
    assert np.abs(caught[:, 1]).max() < 0.0012  # between the legs, flattened
    assert caught[:, 2].min() > -0.0095
    assert caught[:, 2].max() < 0.0005
    np.testing.assert_allclose(T[:3, :3] @ T[:3, :3].T, np.eye(3), atol=1e-9)


def test_unknown_camera_and_blind_world_are_refused(world: World) -> None:
    with pytest.raises(ValueError, match="endoscope_left"):
        world.images(["ceiling"])
    with pytest.raises(ValueError, match="render"):
        World().images(["endoscope_left"])
    with pytest.raises(ValueError, match="it has no patient yet"):
        World(render=True).images(["endoscope_left"])
    with pytest.raises(ValueError, match="wrist_left"):
        CameraSpec(name="ceiling")


def test_environment_sees_colour_depth_and_classes() -> None:
    env = gym.make(
        environment.ENVIRONMENT_ID, obs_mode="rgb+depth+segmentation", render_mode="rgb_array"
    )
    obs, _ = env.reset(seed=SEED)
    assert set(obs["sensor_data"]) == set(CAMERA_NAMES)
    for picture in obs["sensor_data"].values():
        assert picture["rgb"].shape == (1, 128, 128, 3)
        assert picture["depth"].shape == picture["segmentation"].shape == (1, 128, 128, 1)
        assert str(picture["rgb"].dtype) == "torch.uint8"
        assert str(picture["depth"].dtype) == "torch.float32"
        assert str(picture["segmentation"].dtype) == "torch.int16"
    assert "duct" not in " ".join(obs["extra"])
    eye = obs["sensor_data"]["endoscope_left"]
    names = env.unwrapped.segmentation_names()
    found = {names[int(k)] for k in eye["segmentation"].unique()}
    assert {"gallbladder", "duct", "artery", "liver", "peritoneum", "psm1", "psm2"} <= found
    assert {"common bile duct", "hepatic artery"} <= found  # as bulges under the peritoneum
    world = env.unwrapped.world
    _depth_matches_geometry(
        world, eye["depth"][0, ..., 0].numpy(), eye["segmentation"][0, ..., 0].numpy(), names
    )
    assert env.render().shape == (1, 480, 640, 3)
    env.close()


def _depth_matches_geometry(
    world: World, depth_m: np.ndarray, classes: np.ndarray, names: dict[int, str]
) -> None:
    """Check the depth of the gallbladder against its vertices; the drawn mesh is rounder."""
    x = world.tissue.positions()[world.organ.sac_rings.ravel()].astype(float)
    ahead = transform(inverse_pose(T_world_camera(world, "endoscope_left")), x)[:, 0]
    on_sac = depth_m[np.vectorize(names.get)(classes) == "gallbladder"]
    assert abs(on_sac.min() - ahead.min()) < 0.002
    assert on_sac.max() < ahead.max()


def test_small_reflections_on_wet_tissue_move_with_the_lamp(world: World) -> None:
    def fine_light() -> np.ndarray:
        light = world.images(["wrist_left"])["wrist_left"].astype(float)
        return (light - uniform_filter(light, 31, axes=(0, 1))).min(axis=2)

    before = fine_light()
    T_world_endoscope = world.T_world_endoscope.copy()
    T_world_endoscope[:3, 3] += np.array([0.02, 0.0, 0.0])  # moves the lamp, not this camera
    world.T_world_endoscope = T_world_endoscope
    appeared = (fine_light() > before + 15.0).sum()
    assert appeared > 1200  # pixels: about 1700, and about 800 of dry tissue and steel


def test_dye_reddens_the_gallbladder_and_is_gone_when_it_is_washed_off(world: World) -> None:
    def greenness() -> float:
        sac = world.tissue.positions()[world.organ.sac_rings[3:9, 0]].astype(float)
        red, green, _ = pixels(world, sac, world.endoscope_rgb()).mean(axis=0)
        return float(green / red)

    clean = greenness()
    world.conditions = replace(world.conditions, dyed=1.0)
    assert greenness() < 0.8 * clean
    world.conditions = replace(world.conditions, dyed=0.0)
    assert greenness() == clean
