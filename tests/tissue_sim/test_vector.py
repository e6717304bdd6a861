"""Tests of the vector environment: each row equals a single environment."""

import numpy as np
import pytest

from tissue_sim import vector
from tissue_sim.environment import make_single
from tissue_sim.rendering.renderer import renderer_available
from tissue_sim.tools.arms import HOME_JOINTS

SEED = 10_000
HOME = np.tile(HOME_JOINTS, 2).astype(np.float32)


def actions(k: int) -> np.ndarray:
    rows = np.tile(HOME, (2, 1))
    rows[:, 2] += np.array([0.001, 0.002]) * k
    return rows.astype(np.float32)


def test_each_row_is_an_environment_of_its_own() -> None:
    together = vector.make_vec(2)
    seen = [together.reset(seed=SEED)[0], *(together.step(actions(k))[0] for k in range(15))]
    together.close()
    for row in range(2):
        alone = make_single(obs_mode="state")
        path = [alone.reset(seed=SEED + row)[0]]
        path += [alone.step(actions(k)[row])[0] for k in range(15)]
        alone.close()
        np.testing.assert_array_equal(np.stack(seen)[:, row], np.stack(path))


def test_a_single_environment_of_several_moves_when_it_is_stepped() -> None:
    together = vector.make_vec(2)
    together.reset(seed=SEED)
    together.step(actions(0))
    before, *_ = together.step(actions(1))
    seen, *_ = together.envs[0].step(actions(30)[0])  # pyright: ignore[reportAttributeAccessIssue]
    alone = make_single(obs_mode="state")
    alone.reset(seed=SEED)
    *_, own = (alone.step(actions(k)[0])[0] for k in (0, 1, 30))
    assert not np.array_equal(seen, before[0])
    np.testing.assert_array_equal(seen, own)
    together.close()
    alone.close()


def test_after_a_bad_action_no_answer_is_left_over() -> None:
    together = vector.make_vec(2)
    together.reset(seed=SEED)
    bad = actions(0)
    bad[0] = np.nan
    with pytest.raises(ValueError, match="action"):
        together.step(bad)
    after, *_ = together.step(actions(30))
    alone = make_single(obs_mode="state")
    alone.reset(seed=SEED + 1)
    *_, own = (alone.step(actions(k)[1])[0] for k in (0, 30))
    np.testing.assert_array_equal(after[1], own)
    seen, *_ = together.envs[1].step(actions(0)[1])  # pyright: ignore[reportAttributeAccessIssue]
    np.testing.assert_array_equal(seen, alone.step(actions(0)[1])[0])
    together.close()
    alone.close()


@pytest.mark.parametrize("number", [0, -1, 2.0])
def test_a_number_of_environments_that_is_none_is_refused(number: int) -> None:
    with pytest.raises(ValueError, match=f"num_envs = {number} must be a whole number of 1"):
        vector.make_vec(number)


def test_an_environment_that_ended_is_reset_by_the_next_step() -> None:
    together = vector.make_vec(2, max_episode_steps=2)
    together.reset(seed=SEED)
    steps = [together.step(actions(0)) for _ in range(3)]
    together.close()
    assert steps[1][3].all()
    assert not steps[2][3].any()
    assert (steps[2][4]["elapsed_steps"] == 0).all()


@pytest.mark.render
@pytest.mark.skipif(not renderer_available(), reason="SAPIEN finds no Vulkan renderer here")
@pytest.mark.slow
def test_with_pictures_each_environment_is_a_process() -> None:
    together = vector.make_vec(2, obs_mode="rgb")
    seen, _ = together.reset(seed=SEED)
    together.close()
    assert seen["sensor_data"]["endoscope_left"]["rgb"].shape[0] == 2
    assert seen["sensor_data"]["endoscope_left"]["rgb"].std() > 5
