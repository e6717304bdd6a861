"""Define the checkpoints of the learned planner."""

from __future__ import annotations

from pathlib import Path

from planner.correction import CORRECTIONS
from planner.learned.config import PlannerConfig
from planner.learned.network import PlannerNetwork
from planner.learning.checkpoint import Checkpoints
from planner.task import TASKS
from tissue_sim.sensing.observation import VECTOR_SIZE
from tissue_sim.version import WORLD_VERSION

CHECKPOINTS = Checkpoints(
    learner="planner",
    holds="learned planner",
    shipped=Path(__file__).with_name("planner.safetensors"),
    fits={
        "world version": WORLD_VERSION,
        "schema": 5,
        "observation size": VECTOR_SIZE,
        "instructions": len(TASKS) + len(CORRECTIONS),
    },
    config_type=PlannerConfig,
    model_from=PlannerNetwork,
)
