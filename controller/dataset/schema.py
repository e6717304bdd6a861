"""Define the schema of a dataset: the columns of a frame, and the texts of all instructions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import prod

import pyarrow as pa

from controller.action import ACTION_SIZE
from planner.correction import CORRECTIONS
from planner.procedure.cholecystectomy import TASKS
from tissue_sim.constants import CONTROL_HZ
from tissue_sim.sensing.observation import ENCODED, VECTOR_LAYOUT, VECTOR_SIZE

SCHEMA_VERSION = 7  # raise it when a column is added, dropped or changes its meaning
FPS = CONTROL_HZ
TEXTS = tuple(said.text for said in (*TASKS, *CORRECTIONS))  # `task_index` counts these


@dataclass(frozen=True, kw_only=True)
class Feature:
    """A column: the type of its numbers, and their count per frame.

    Attributes:
        dtype: The type's name in numpy, or "string".
    """

    dtype: str
    size: int = 1

    @property
    def arrow(self) -> pa.DataType:
        """Return Arrow's type: a list of fixed length if a frame has several numbers."""
        scalar = pa.type_for_alias(self.dtype)
        return scalar if self.size == 1 else pa.list_(scalar, self.size)

    @property
    def is_number(self) -> bool:
        """Return whether statistics of the column make sense."""
        return self.dtype not in ("string", "bool")

    def shape(self, frames: int) -> tuple[int, ...]:
        """Return the shape of the column's array."""
        return (frames,) if self.size == 1 else (frames, self.size)


ENCODED_SIZE = sum(prod(VECTOR_LAYOUT[name]) for name in ENCODED)
STATE, TISSUE = "observation.state", "observation.environment_state"  # LeRobot's names
PICTURES = "observation.images."  # and a camera's name
PICTURE_SHAPE = (240, 320, 3)  # height, width, channels
UNNAMED, NOT_FORKED = -1.0, -1
DEMONSTRATED: dict[str, Feature] = {
    STATE: Feature(dtype="float32", size=ENCODED_SIZE),
    TISSUE: Feature(dtype="float32", size=VECTOR_SIZE - ENCODED_SIZE),
    "privileged.state": Feature(dtype="float32", size=VECTOR_SIZE),
    "action": Feature(dtype="float32", size=ACTION_SIZE),
    "timestamp": Feature(dtype="float32"),
    "frame_index": Feature(dtype="int64"),
    "task_index": Feature(dtype="int64"),
    "instruction": Feature(dtype="string"),
    "correction": Feature(dtype="string"),
    "flag": Feature(dtype="bool"),
    "task": Feature(dtype="int64"),
    "kind": Feature(dtype="string"),
    "left": Feature(dtype="float32", size=2),
    "expert": Feature(dtype="bool"),
    "forked_from": Feature(dtype="int64"),
    "segment": Feature(dtype="int64"),
    "seed": Feature(dtype="int64"),
}
"""The columns of one episode.

observation.state: Measurements of encoders and motor currents before the action (`ENCODED`).
observation.environment_state: The rest of `Observation.vector()`, the tissue, as the episode's
    sense observed it. A dataset with pictures does not have this column.
privileged.state: The whole vector without errors, and which points no camera sees. No robot has
    this state: it serves to sense the episode again with other errors
    (`tissue_sim.sensing.tracker`).
action: `ToolAction.vector()` as commanded, after the safety filter. If injected noise disturbed
    the action, the column has the action that the expert asked for.
timestamp: Time since the first frame, s. Tool exchanges and holds, in which policies pause,
    are left out.
task_index: Row of `TEXTS` that was given; the text is also in `instruction`.
correction: One of the 18 corrections, or "". It is the given correction or, under the flag, the
    correction that would have asked for the motion that follows.
flag: A correction is needed: an error is not undone yet, or a person gives a correction.
task: The current task, 1 to 25.
kind: Kind of the episode: "nominal", "recovery:" and the perturbation's name, "correction",
    "order", "turns", "rollout", "fork", "forked-turns" or "intervention". All after "order" may
    also carry a perturbation's name. In a rollout of a learned controller, `task`, `flag` and
    `correction` are the labels that should have been given.
left: What is left of the correction in `correction`: the arm's distance, m, and the opening of the
    jaws, rad. -1 where none was named.
expert: False if a perturbation, noise or a learned controller led the arms. Such frames are not to
    be imitated.
forked_from: -1, but in forks the `frame_index` of the frame that the fork begins at: from this
    state the expert carried out another command. Forks come after all other frames.
segment: Increases by one after each tool exchange or hold of the arms, where a policy starts again,
    and from fork to fork.
"""


def demonstrated(cameras: Sequence[str]) -> Mapping[str, Feature]:
    """Return the columns of an episode that these cameras, or no cameras, filmed."""
    return {name: f for name, f in DEMONSTRATED.items() if not (cameras and name == TISSUE)}


def features(cameras: Sequence[str]) -> Mapping[str, Feature]:
    """Return the columns of a dataset; `index` counts all frames, and pictures are in videos."""
    numbers = {name: Feature(dtype="int64") for name in ("episode_index", "index")}
    return {**demonstrated(cameras), **numbers}
