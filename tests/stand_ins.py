"""Untrained checkpoints in place of those that no policy of this world version was trained for yet.

A change of physics raises the world's version, and policies are trained again later. Until then the
loop, the files and the command line are tested with networks that have learned nothing.
"""

from pathlib import Path

import pytest
import torch
from torch import nn

from controller.diffusion import policy as of_controller
from controller.perception import checkpoint as of_perception
from planner.learned import network as of_planner
from planner.learning.checkpoint import Checkpoints
from tests.controller.perception.ideal_views import prior
from tests.made_once import MadeOnce

LEARNERS: dict[str, Checkpoints] = {
    learner.learner: learner
    for learner in (of_planner.CHECKPOINTS, of_controller.CHECKPOINTS, of_perception.CHECKPOINTS)
}
VIEWS = ("endoscope_left", "endoscope_left_close", "wrist_left_tip", "wrist_right_tip")
TRAINED = all(learner.shipped.exists() for learner in LEARNERS.values())
needs_trained = pytest.mark.skipif(
    not TRAINED, reason="no policy of this world version is trained yet"
)


def make_stand_ins(folder: Path) -> dict[str, Path]:
    """Write an untrained checkpoint for each learner without a shipped one; return all paths."""
    torch.manual_seed(0)
    paths = {}
    for name, learner in LEARNERS.items():
        paths[name] = learner.shipped
        if not learner.shipped.exists():
            paths[name] = folder / learner.shipped.name
            learner.save(paths[name], _untrained(name))
    return paths


def stand_in(made_once: MadeOnce) -> None:
    """Let each learner without a shipped checkpoint have an untrained one, in this process."""
    for name, path in made_once("stand-ins", make_stand_ins).items():
        object.__setattr__(LEARNERS[name], "shipped", path)


def _untrained(name: str) -> nn.Module:
    if name == "planner":
        return of_planner.PlannerNetwork(of_planner.PlannerConfig())
    if name == "controller":
        return of_controller.Policy(of_controller.PolicyConfig())
    sizes = ((160, 120), (160, 120), (128, 128), (128, 128))
    config = of_perception.PerceptionConfig(views=VIEWS, sizes=sizes)
    return of_perception.PerceptionModel(config, prior())
