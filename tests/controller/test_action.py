"""Tests of an action: wrong shapes and wrong numbers are refused, and a hold moves nothing."""

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from controller.action import ToolAction, hold
from tissue_sim.frames import rotation_from_6d, rotation_to_6d

STILL = {"move_endoscope_m": np.zeros((2, 3)), "jaw_rad": np.zeros(2)}
STILL["turn_tool"] = np.tile([1.0, 0.0, 0.0, 0.0, 1.0, 0.0], (2, 1))


@pytest.mark.parametrize(
    ("name", "value", "shape"),
    [
        ("move_endoscope_m", np.zeros(3), "(2, 3)"),
        ("move_endoscope_m", np.full((2, 3), np.nan), "(2, 3)"),
        ("turn_tool", np.zeros((2, 3, 3)), "(2, 6)"),
        ("turn_tool", np.full((2, 6), np.inf), "(2, 6)"),
        ("jaw_rad", 0.3, "(2,)"),
        ("jaw_rad", np.array([0.3, np.nan]), "(2,)"),
        ("jaw_rad", None, "(2,)"),
        ("jaw_rad", "ab", "(2,)"),
        ("jaw_rad", np.array([0.3, 1j]), "(2,)"),
        ("jaw_rad", np.array([True, False]), "(2,)"),
        ("jaw_rad", np.array([0.3, None]), "(2,)"),
        ("turn_tool", [[1.0], [1.0, 2.0]], "(2, 6)"),
        ("move_endoscope_m", torch.zeros(1, 2, 3), "(2, 3)"),
        ("move_endoscope_m", torch.full((2, 3), torch.nan), "(2, 3)"),
        ("jaw_rad", [torch.ones((), requires_grad=True)] * 2, "(2,)"),
        ("jaw_rad", torch.zeros(2, device="meta"), "(2,)"),
    ],
)
def test_wrong_shape_or_no_number_is_refused_and_says_which(name, value, shape):
    with pytest.raises(ValueError, match="finite numbers") as refusal:
        ToolAction(**STILL | {name: value})
    assert f"{name} must be {shape}" in str(refusal.value)


@pytest.mark.parametrize(
    "kind",
    [
        np.float32,
        list,
        torch.from_numpy,
        lambda array: torch.from_numpy(array).float().requires_grad_(),
        lambda array: torch.from_numpy(array).bfloat16(),
        lambda array: torch.from_numpy(array).int(),
        lambda array: array.astype(int),
        lambda array: torch.from_numpy(array)[:, None].expand(-1, 2, *array.shape[1:])[:, 0],
    ],
    ids=["float32", "list", "tensor", "graph", "bfloat16", "int tensor", "int", "view"],
)
def test_an_action_of_arrays_lists_or_tensors_is_the_same_in_floats(kind):
    given = {name: np.round(array) for name, array in STILL.items()}
    action = ToolAction(**{name: kind(array) for name, array in given.items()})
    for name, array in given.items():
        taken = getattr(action, name)
        assert (type(taken), taken.dtype, taken.flags.writeable) == (np.ndarray, float, False)
        np.testing.assert_array_equal(taken, array)


@pytest.mark.parametrize(
    "six",
    [np.zeros(6), np.ones(6), [1.0, 0.0, 0.0, -2.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 1.0, 0.0]],
)
@pytest.mark.parametrize("arm", [0, 1])
def test_columns_that_give_no_rotation_are_refused_and_it_says_what_no_turn_is(six, arm):
    turn = np.copy(STILL["turn_tool"])
    turn[arm] = six
    with pytest.raises(ValueError, match=r"not parallel; no turn is \(1, 0, 0, 0, 1, 0\)"):
        ToolAction(**STILL | {"turn_tool": turn})


@given(seed=st.integers(0, 2**32 - 1), size=st.floats(0.1, 9.0))
def test_columns_of_any_rotation_and_length_are_taken(seed, size):
    six = size * rotation_to_6d(Rotation.random(random_state=seed).as_matrix())
    ToolAction(**STILL | {"turn_tool": np.tile(six, (2, 1))})


def test_hold_asks_for_no_motion_and_the_jaws_given():
    action = hold([0.3, -0.1])
    assert not action.move_endoscope_m.any()
    for six in action.turn_tool:
        np.testing.assert_array_equal(rotation_from_6d(six), np.eye(3))
    np.testing.assert_array_equal(action.jaw_rad, [0.3, -0.1])


def test_the_vector_is_move_turn_and_jaw_of_the_left_arm_then_of_the_right():
    numbers = np.arange(20.0).reshape(2, 10)
    action = ToolAction(
        move_endoscope_m=numbers[:, :3], turn_tool=numbers[:, 3:9], jaw_rad=numbers[:, 9]
    )
    np.testing.assert_array_equal(action.vector(), np.arange(20.0))
