"""Tests of the body: it moves as commanded, at the right speed, and with all its parts."""

import numpy as np

from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.frames import UP
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.tools.arms import ASSISTANT, LIVER, JointCommand
from tissue_sim.world import World

SEED = 7
FLOAT32_M = 2e-8  # rounding of a position of 0.1 m, twice


def hold(world: World) -> None:
    world.step(JointCommand(joints=world.target))


def sway(k: int) -> np.ndarray:
    return 0.003 * np.sin(0.2 * k) * UP


def held(world: World) -> dict[str, np.ndarray]:
    """Return the current points of the parts that the body holds."""
    tissue, n = world.tissue, len(world.organ.bed_vertices)
    liver, assistant = (
        next(e for e in world.scene.entities if e.name == name) for name in (LIVER, ASSISTANT)
    )
    return {
        "fixed ends": tissue.positions()[world.organ.fixed].astype(float),
        "strands": tissue.host("anchor_point")[0, :n].astype(float),
        "bed": tissue.host("bed_point").astype(float),
        "liver": np.array([liver.pose.p], float),
        "assistant": np.array([assistant.pose.p], float),
    }


def test_everything_it_holds_moves_by_the_offset_in_one_control_step(world):
    start = held(world)
    for k in range(1, 20):
        world.shift_body(sway(k))
        hold(world)
        for name, points in held(world).items():
            moved = points - start[name]
            np.testing.assert_allclose(moved, np.tile(sway(k), (len(moved), 1)), atol=FLOAT32_M)


def test_fixed_ends_have_the_velocity_at_which_they_move(world):
    for k in range(1, 10):
        before = held(world)["fixed ends"]
        world.shift_body(sway(k))
        hold(world)
        moved = held(world)["fixed ends"] - before
        velocity = world.tissue.host("velocity")[0, : len(world.organ.fixed)][world.organ.fixed]
        np.testing.assert_allclose(
            velocity, moved / CONTROL_PERIOD_S, atol=2 * FLOAT32_M / CONTROL_PERIOD_S
        )
    hold(world)
    hold(world)
    assert not world.tissue.host("velocity")[0, : len(world.organ.fixed)][world.organ.fixed].any()


def test_the_tissue_follows_and_hangs_as_before(world):
    for _ in range(60):
        hold(world)
    before = world.tissue.positions().astype(float)
    for k in range(60):
        world.shift_body((k + 1) / 60 * 0.006 * UP)
        hold(world)
    for _ in range(90):
        hold(world)
    moved = world.tissue.positions() - before - 0.006 * UP
    assert np.linalg.norm(moved, axis=1).max() < 3e-4


def test_a_zero_offset_changes_nothing(world):
    for _ in range(5):
        hold(world)
    without_command = world.state()
    world.reset(textbook_from_seed(SEED))
    for _ in range(5):
        world.shift_body(np.zeros(3))
        hold(world)
    for name, values in world.state()["tissue"].items():
        np.testing.assert_array_equal(values, without_command["tissue"][name], err_msg=name)


def test_a_state_saved_in_motion_continues_bit_for_bit(world):
    for k in range(1, 6):
        world.shift_body(sway(k))
        hold(world)
    world.shift_body(sway(6))
    saved = world.state()
    paths = []
    for _ in range(2):
        world.restore(saved)
        path = []
        for k in range(7, 15):
            hold(world)
            world.shift_body(sway(k))
            path.append(np.vstack([world.tissue.positions(), *held(world).values()]))
        paths.append(np.stack(path))
        world.shift_body(0.02 * UP)
        hold(world)
    np.testing.assert_array_equal(*paths)
