"""Tests of what policies learn from an episode: who said what, which frames, sensed how."""

from dataclasses import replace

import numpy as np
import pytest

from controller.dataset.choice import Choice
from controller.dataset.merge import merge
from controller.dataset.part import part_bytes
from controller.dataset.reader import COPIES, sensed_copy
from controller.dataset.rollouts import rollout_of, rollouts
from controller.dataset.schema import NOT_FORKED, UNNAMED
from controller.dataset.tables import strings
from controller.diffusion.config import PolicyConfig
from controller.diffusion.demonstrations import sensed
from controller.diffusion.windows import Windows
from planner.correction import CORRECTIONS
from planner.learned.rollout import NOT_SAID
from planner.procedure.cholecystectomy import TASKS
from tests.controller.dataset.episodes import random_episode

SEED = 6


def made(kind="nominal", **columns):
    frames = len(next(iter(columns.values())))
    episode = random_episode(SEED, frames)
    columns |= {"seed": np.full(frames, SEED)}
    header = replace(episode.header, kind=kind)
    return replace(episode, header=header, columns=episode.columns | columns)


@pytest.fixture
def spoken():
    """Return an episode in which the second frame's word is a correction."""
    return made(
        kind="rollout:wrong-tube",
        task_index=np.array([2, len(TASKS) + 1, 3, 3]),
        task=np.array([3, 3, 4, 5]),
        flag=np.array([False, True, True, False]),
        correction=strings(["", CORRECTIONS[1].text, CORRECTIONS[4].text, CORRECTIONS[4].text]),
    )


def test_a_planner_learns_the_tasks_and_corrections_that_were_said_and_those_that_were_right(
    spoken,
):
    rollout = rollout_of(spoken)
    assert rollout.said.tolist() == [2, 2, 3, 3]
    assert rollout.corrected.tolist() == [NOT_SAID, 1, NOT_SAID, NOT_SAID]
    assert rollout.task.tolist() == [2, 2, 3, 4]
    assert rollout.correction.tolist() == [NOT_SAID, 1, 4, NOT_SAID]
    assert rollout.success == spoken.header.success
    assert rollout.patient == SEED
    assert rollout.learned
    assert not rollout_of(replace(spoken, header=random_episode(SEED).header)).learned


def test_a_correction_before_any_task_was_said_counts_as_said_during_the_right_task():
    episode = made(task_index=np.array([len(TASKS), 7]), task=np.array([5, 8]))
    assert rollout_of(episode).said.tolist() == [4, 7]


def test_a_planner_learns_nothing_from_orders_that_it_cannot_know(tmp_path):
    kinds = ("nominal", "order:duct-last", "rollout:grasp-slip", "turns")
    paths = [tmp_path / f"{k}.parquet" for k in range(len(kinds))]
    for path, kind in zip(paths, kinds, strict=True):
        path.write_bytes(part_bytes(made(kind, task=np.array([3, 4]))))
    merge(paths, tmp_path)
    assert [r.learned for r in rollouts([tmp_path])] == [False] * COPIES + [True] * COPIES
    assert len(rollouts([tmp_path], Choice(leave_out=("nominal",)))) == COPIES


def test_a_demonstration_is_split_where_tools_were_exchanged_and_loses_no_frame():
    heard = np.array([2, len(TASKS), 2, 2, len(TASKS) + 1])
    episode = made(segment=np.array([0, 0, 0, 1, 1]), task_index=heard)
    corrected = (heard >= len(TASKS))[:, None]
    left = np.where(corrected, episode.columns["left"], UNNAMED)  # a label's is not in force
    runs = list(sensed(episode, copy=0))
    assert [len(run.actions) for run in runs] == [3, 2]
    whole = sensed_copy(episode.columns["privileged.state"], SEED, 0)
    for name, expected in (
        ("actions", episode.columns["action"]),
        ("expert", episode.columns["expert"]),
        ("task", episode.columns["task"] - 1),
        ("left", left),
        ("states", whole),
    ):
        np.testing.assert_array_equal(np.concatenate([getattr(r, name) for r in runs]), expected)


@pytest.fixture
def forked():
    """Return an episode of ten frames, and two forks of three frames after its sixth."""
    forked_from = np.full(16, NOT_FORKED)
    forked_from[10:] = 6
    return made(forked_from=forked_from, segment=np.repeat([0, 1, 2, 3], [4, 6, 3, 3]))


def test_a_fork_goes_on_from_what_the_tracker_knew_and_from_the_motions_before(forked):
    exact, actions = forked.columns["privileged.state"], forked.columns["action"]
    *runs, left, right = sensed(forked, copy=0)
    np.testing.assert_array_equal(
        np.concatenate([run.states for run in runs]), sensed_copy(exact[:10], SEED, 0)
    )
    for fork, rows in ((left, slice(10, 13)), (right, slice(13, 16))):
        assert fork.begins == 2  # the segment begins at the fifth frame
        instead = np.concatenate([exact[:6], exact[rows]])
        np.testing.assert_array_equal(fork.states, sensed_copy(instead, SEED, 0)[4:])
        np.testing.assert_array_equal(fork.actions[:2], actions[4:6])
    windows = Windows([left], PolicyConfig())
    assert len(windows) == left.expert[2:].sum()


def test_forks_count_once_and_a_planner_does_not_learn_from_them(forked):
    assert [len(run.task) for run in sensed(forked, copy=1)] == [4, 6]
    assert len(rollout_of(forked).states) == 10


def test_each_copy_of_each_patient_is_sensed_with_its_own_errors_and_the_same_each_time():
    exact = random_episode(SEED).columns["privileged.state"]
    same, again, other_copy, other_patient = (
        sensed_copy(exact, seed, copy) for seed, copy in ((5, 0), (5, 0), (5, 1), (6, 0))
    )
    np.testing.assert_array_equal(same, again)
    assert (same != exact).any()
    assert (same != other_copy).any()
    assert (same != other_patient).any()
