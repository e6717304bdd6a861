"""Laws of what a planner is trained by."""

import pytest
import torch

from planner.learned.features import N_CORRECTIONS, N_TASKS
from planner.learned.network import Opinion
from planner.learned.rollout import NOT_SAID, Labels
from planner.learned.training import loss_of

FAIR = torch.tensor([True, True, False, False])


def loss(correction, fails, *, flag=0.3, sure=0.1):
    n = len(FAIR)
    opinion = Opinion(
        task=torch.zeros(n, N_TASKS),
        flag=torch.full((n,), flag),
        correction=torch.zeros(n, N_CORRECTIONS),
        progress=torch.full((n,), 0.5),
        fails=torch.full((n,), sure),
    )
    labels = Labels(
        task=torch.zeros(n, dtype=torch.long),
        correction=torch.tensor(correction),
        progress=torch.full((n,), 0.5),
        fails=torch.tensor(fails),
    )
    return loss_of(opinion, labels, FAIR).item()


WANTED = [3, NOT_SAID, 3, NOT_SAID]
FAILS = [1.0, 0.0, 1.0, 0.0]


def test_chances_are_learnt_from_steps_drawn_alike_and_from_no_others():
    assert loss(WANTED, [1.0, 0.0, 0.0, 1.0]) == pytest.approx(loss(WANTED, FAILS))
    assert loss([3, NOT_SAID, NOT_SAID, 3], FAILS) == pytest.approx(loss(WANTED, FAILS))
    assert loss(WANTED, [0.0, 0.0, 1.0, 0.0]) != pytest.approx(loss(WANTED, FAILS))
    assert loss([NOT_SAID, NOT_SAID, 3, 3], FAILS) != pytest.approx(loss(WANTED, FAILS))


def test_what_an_episode_does_not_tell_does_not_count():
    untold = [1.0, float("nan"), 1.0, 0.0]
    assert loss(WANTED, untold, sure=9.0) < loss(WANTED, FAILS, sure=9.0)
    assert loss(WANTED, untold) == pytest.approx(loss(WANTED, [1.0, float("nan"), 0.0, 1.0]))
