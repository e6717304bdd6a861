"""Record an episode as training data, frame by frame."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from controller.dataset.schema import NOT_FORKED, STATE, TEXTS, TISSUE, UNNAMED
from controller.dataset.tables import strings
from controller.driver import motion_between, rig_in
from controller.expert.skills import JAW_TIME_S
from planner.instruction import Instruction
from scenarios.demonstration.failures import FailureTracker
from scenarios.demonstration.labels import SILENCE, WINDOW_STEPS, Advice, advice_from
from scenarios.loop.results import EpisodeResult
from scenarios.loop.step import Step
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.sensing.observation import Observation, encoded_and_tissue
from tissue_sim.sensing.tracked import Occluded

if TYPE_CHECKING:
    from tissue_sim.world import World

PAUSE_STEPS = round(JAW_TIME_S / CONTROL_PERIOD_S)  # the expert opens jaws that are open already
_TASK_INDEX = {text: k for k, text in enumerate(TEXTS)}


def is_frame(step: Step) -> bool:
    """Return whether a step becomes a frame: exchanges, holds and a kept place do not."""
    return not (step.exchange or step.instruction.hold or step.stays)


class DemonstrationRecorder:
    """Observes one episode of the expert, of a learned controller, or of both in turns.

    Attributes:
        result: The episode's result, once the episode has ended.
    """

    def __init__(self, expert_acts: Callable[[], bool], filmed: bool = False) -> None:
        """Begin without frames; `expert_acts` says whether the last motions are the expert's.

        If cameras film the episode, the columns omit the tissue, which is in the pictures.
        """
        self._expert_acts, self._filmed = expert_acts, filmed
        self.result: EpisodeResult | None = None
        self._frames: list[dict[str, Any]] = []
        self._failures, self._failed = FailureTracker(), False  # whether a failure persists now
        self._segment = 0

    def on_reset(self, world: World) -> None:
        """Observe the first frame exactly."""
        self._world, self._truth = world, Occluded()
        self._exact = self._truth.observe(world, world.observe())
        self._commanded = world.target

    def on_step(self, step: Step) -> None:
        """Add a frame, except during tool exchanges and holds."""
        if not is_frame(step):
            self._segment += 1
        else:
            self._frames.append(self._frame(step))
            self._failed = self._failures.after(step, self._world)
        self._exact = self._truth.observe(self._world, step.exact)
        self._commanded = step.command.joints

    def on_end(self, result: EpisodeResult) -> None:
        """Keep the episode's result."""
        self.result = result

    @property
    def has_frames(self) -> bool:
        """Return whether there is a frame."""
        return bool(self._frames)

    def columns(self, seed: int, kind: str) -> dict[str, np.ndarray]:
        """Return all frames so far as columns, by the names of `schema.demonstrated`.

        Another thread may add steps meanwhile; their frames are left out.

        Raises:
            ValueError: There is no frame yet.
        """
        frames = list(self._frames)
        if not frames:
            raise ValueError(f"the procedure of seed {seed} ended before its first frame")
        n = len(frames)
        advice, flags = zip(*self._labels(frames), strict=True)
        numbers = np.arange(n)
        heard = [f["instruction"] for f in frames]
        state, tissue = encoded_and_tissue(np.stack([f["seen"].vector() for f in frames]))
        return {
            STATE: state,
            **({} if self._filmed else {TISSUE: tissue}),
            "privileged.state": np.stack([f["exact"].vector() for f in frames]),
            "action": np.stack([f["action"] for f in frames]).astype(np.float32),
            "timestamp": (numbers * CONTROL_PERIOD_S).astype(np.float32),
            "frame_index": numbers,
            "task_index": np.array([_TASK_INDEX[text] for text in heard]),
            "instruction": strings(heard),
            "correction": strings([a.correction for a in advice]),
            "flag": np.array(flags),
            "task": np.array([f["task"] for f in frames]),
            "kind": strings([kind] * n),
            "left": np.array([a.left for a in advice], np.float32),
            "expert": np.array([f["expert"] for f in frames]),
            "forked_from": np.full(n, NOT_FORKED),
            "segment": np.unique([f["segment"] for f in frames], return_inverse=True)[1],
            "seed": np.full(n, seed),
        }

    def _frame(self, step: Step) -> dict[str, Any]:
        correction, guided = step.instruction.correction, step.guided is not None
        if step.disturbed and step.asked is not None and not guided:
            action = step.asked
        else:
            action = motion_between(rig_in(self._world), self._commanded, step.command.joints)
        return {
            "seen": step.before,
            "exact": self._exact,
            "action": action.vector(),
            "instruction": step.instruction.text,
            "heard": heard_of(step.instruction),
            "task": step.instruction.task.index,
            "expert": guided or (not step.disturbed and self._expert_acts()),
            "corrected": bool(correction) and step.instruction.source == "human",
            "failed": self._failed and step.asked is not None,
            "segment": self._segment,
        }

    def _labels(self, frames: Sequence[dict[str, Any]]) -> list[tuple[Advice, bool]]:
        """Return the correction of each frame, and whether the correction is needed."""
        labels = []
        for k, frame in enumerate(frames):
            wanted = _motion_in_words(frames, k) if frame["failed"] else SILENCE
            heard = frame["heard"]
            said = heard if heard.correction else wanted
            labels.append((said, wanted != SILENCE or frame["corrected"]))
        return labels


def heard_of(said: Instruction) -> Advice:
    """Return the correction in force, and what is left of it."""
    both = said.left_m, said.left_rad
    left_m, left_rad = (UNNAMED if left is None else max(left, 0.0) for left in both)
    text = said.correction.text if said.correction else ""
    return Advice(correction=text, left=(left_m, left_rad))


def _motion_in_words(frames: Sequence[dict[str, Any]], k: int) -> Advice:
    """Return the correction that describes the next second, or a second after a pause."""
    starts = range(k, min(k + PAUSE_STEPS, len(frames)))
    return advice_from(_motion_from(frames, start) for start in starts)


def _motion_from(frames: Sequence[dict[str, Any]], k: int) -> tuple[np.ndarray, np.ndarray]:
    here = frames[k]["exact"]
    there = frames[min(k + WINDOW_STEPS, len(frames) - 1)]["exact"]
    return _tips_m(there) - _tips_m(here), there.joints[:, 6] - here.joints[:, 6]


def _tips_m(observation: Observation) -> np.ndarray:
    return observation.tips_endoscope[:, :3, 3]
