"""Tests of the assistant's grasper: it holds the fundus, and stays clear of both arms' work."""

import numpy as np
import pytest

from tissue_sim.frames import UP, unit
from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.patient.anatomy import anatomy_from_seed
from tissue_sim.patient.assistant import T_world_shaft, assistant_of, shaft_length_m
from tissue_sim.patient.organ import build_organ
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.tools.arms import JointCommand, port_pose
from tissue_sim.world import World

SEED = 7
SEEDS = range(40)
WORK_M = 0.04  # around the field's centre, where the arms work
CLEAR_M = 0.02  # between the shaft and that space


def test_the_fundus_stays_where_the_assistant_holds_it_while_the_neck_is_pulled() -> None:
    organ = build_organ(textbook_from_seed(SEED))
    tissue = Tissue([organ])
    fundus, neck = organ.sac_rings[-1], organ.sac_rings[1]
    tissue.host("load")[0, neck] = 0.5 / len(neck) * UP
    before = tissue.positions().copy()
    for _ in range(60):
        tissue.step()
    moved = np.linalg.norm(tissue.positions() - before, axis=1)
    assert moved[neck].max() > 0.002
    assert moved[fundus].max() == 0.0


def test_the_fundus_breathes_with_the_body(world: World) -> None:
    fundus = world.organ.sac_rings[-1]
    before = world.tissue.positions()[fundus].copy()
    world.shift_body(0.003 * UP)
    world.step(JointCommand(joints=world.target))
    moved = world.tissue.positions()[fundus] - before
    np.testing.assert_allclose(moved, np.tile(0.003 * UP, (len(fundus), 1)), atol=1e-7)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_shaft_leaves_the_field_upwards_clear_of_both_arms(seed: int) -> None:
    assistant = assistant_of(build_organ(anatomy_from_seed(seed)))
    line = np.linspace(assistant.tip_m, assistant.port_m, 200)
    assert (np.diff(line @ UP) > 0.0).all()
    assert np.linalg.norm(line, axis=1).min() > WORK_M
    for arm in range(2):
        shaft = np.linspace(port_pose(arm)[:3, 3], np.zeros(3), 200)
        apart = np.linalg.norm(line[:, None] - shaft, axis=2)
        assert apart.min() > CLEAR_M


def test_the_jaws_are_in_the_fundus_and_the_shaft_ends_at_the_port() -> None:
    for seed in SEEDS:
        organ = build_organ(anatomy_from_seed(seed))
        assistant, last = assistant_of(organ), organ.vertices[organ.sac_rings[-1]]
        assert np.linalg.norm(last - assistant.tip_m, axis=1).min() < 0.005
        T, half = T_world_shaft(assistant), 0.5 * shaft_length_m(assistant)
        np.testing.assert_allclose(T[:3, :3] @ T[:3, :3].T, np.eye(3), atol=1e-12)
        np.testing.assert_allclose(T[:3, 3] + half * T[:3, 0], assistant.port_m, atol=1e-12)
        np.testing.assert_allclose(T[:3, 0], unit(assistant.port_m - assistant.tip_m), atol=1e-12)
