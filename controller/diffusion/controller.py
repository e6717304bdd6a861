"""Run the diffusion policy as a controller, whose only input is observations and commands."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from controller.action import ACTION_SIZE, Chunk, hold
from controller.diffusion.chunk_frame import JAWS, actions_of, given_past, motion_of
from controller.diffusion.command import encoded
from controller.diffusion.config import PolicyConfig
from controller.diffusion.dead_time import MAX_STEPS, DeadTime, foreseen
from controller.diffusion.graph import Sampler
from controller.diffusion.policy import CHECKPOINTS
from controller.diffusion.rules.chunk_rules import RULES, ChunkRules
from controller.diffusion.scene.body_frame import BodyFrame
from controller.diffusion.scene.scene import Scene
from planner.correction import Correction
from planner.instruction import Instruction
from planner.learning.networks import kept
from planner.policy_setup import PolicySetup
from planner.procedure.task import Task
from planner.rules.rule_use import RuleUse
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import Observation, part_of

FADE = 4  # motions over which a new chunk takes over from the running one


class ControllerDiffusion:
    """Returns one motion at a time, so that the policy observes every control step.

    The next chunk takes over when `play` motions of the running chunk have been played. The next
    chunk is computed from the observation `delay` steps before, as if computing took that long,
    and from the motions up to its start. Its first motions are blended with the remaining motions
    of the running chunk, so that accelerations at the joint are like those inside chunks. Rules
    make the final changes to a chunk (`rules`). A new command drops the running chunk; the next
    starts at once from the played motions. All motions are in a frame that moves with the body
    (`body_frame`). If motions arrive late (`dead_time`), the predicted tool poses replace the
    observed ones.

    Some rules, or all, can be left out, to measure their effect.

    Attributes:
        place: Place of the last motion in its chunk. "fresh" is the first motion of a chunk without
            a predecessor. "joint" is the first motion of a chunk that took over from another.
            "inside" is any other motion.
    """

    obeys_corrections = True

    def __init__(
        self,
        config: PolicyConfig,
        sampler: Sampler,
        seed: int = 0,
        delay: int = 0,
        *,
        without_rules: Collection[str] = (),
    ) -> None:
        if not 0 <= delay <= config.max_delay:
            raise ValueError(f"delay must be 0 to {config.max_delay} control steps, got {delay}")
        self._config, self._sampler, self._delay = config, sampler, delay
        self._rules = ChunkRules(without_rules)
        self._chance = np.random.default_rng(seed)
        self._body, self._dead_time = BodyFrame(), DeadTime()
        self.reset()

    def reset(self) -> None:
        """Forget observations and motions, but not the robot's delay and the body's place."""
        self._seen: deque[NDArray[np.float32]] = deque(maxlen=max(self._config.history) + 1)
        self._played: deque[Array] = deque(maxlen=self._config.past + MAX_STEPS + 1)
        self._body.reset()
        self._dead_time.reset()
        self._drop()

    def act(self, observation: Observation, instruction: Instruction) -> Chunk:
        """Return the next motion, a chunk of one."""
        seen = self._body.at_rest(observation.vector())
        self._seen.append(seen)
        self._dead_time.update(part_of(seen, "tips_endoscope")[..., 3])
        said = None if self._config.wordless else (instruction.task, instruction.correction)
        if said != self._said:
            self._drop()
            self._said = said
        fresh = not len(self._running)
        if fresh:
            self._compute_chunk(observation, instruction, n_committed=0)
        elif self._n_played == self._config.play - self._delay:
            self._compute_chunk(observation, instruction, n_committed=self._delay)
        self.place = "fresh" if fresh else "inside" if self._n_played else "joint"
        row, self._running = self._running[0], self._running[1:]
        self._n_played += 1
        self._played.append(row)
        self._dead_time.ask(row)
        return (motion_of(self._body.along(row)),)

    def rule_uses(self) -> tuple[RuleUse, ...]:
        """Return the use of each rule on chunks since the controller was made."""
        return self._rules.uses()

    def _drop(self) -> None:
        self.place = "fresh"
        self._said: tuple[Task, Correction | None] | None = None
        self._running: Array = np.empty((0, ACTION_SIZE))

    def _compute_chunk(
        self, observation: Observation, instruction: Instruction, n_committed: int
    ) -> None:
        """Compute a new chunk that follows the committed motions."""
        committed, rest = np.split(self._running, [n_committed])
        if not self._played:
            self._played.append(hold(observation.joints[:, 6]).vector())
        rows = np.concatenate([self._played, committed])
        given = given_past(rows, self._config.past)
        config, shape = self._config, (self._config.horizon, ACTION_SIZE)
        chunk = self._sampler(
            {
                "history": self._history(),
                **{name: part.numpy() for name, part in encoded(instruction, config).items()},
                "delay": np.array(n_committed),
                "noise": self._chance.standard_normal(shape, np.float32),
                **given,
            }
        )
        scene = Scene(self._foreseen(0), is_corrected=instruction.correction is not None)
        commanded = rows[-self._config.past - 1 :, JAWS]
        chunk = self._rules.apply(chunk.astype(float), scene, instruction.task, commanded)
        self._running = np.concatenate([committed, _faded(rest, actions_of(chunk))])
        self._n_played = -n_committed  # motions of this chunk

    def _history(self) -> NDArray[np.float32]:
        newest = len(self._seen) - 1
        return np.stack([self._foreseen(min(ago, newest)) for ago in self._config.history])

    def _foreseen(self, ago: int) -> NDArray[np.float32]:
        """Return the observation `ago` steps before, with the tools moved ahead by the delay."""
        seen, late = self._seen[-1 - ago], self._dead_time.steps
        rows = list(self._played)[: len(self._played) - ago][-late - 1 :]
        return foreseen(seen, np.stack(rows)) if late and rows else seen


def _faded(old: Array, new: Array) -> Array:
    """Return motions (n, 20) of a chunk, blended over `FADE` motions with the old ones (m, 20)."""
    n = min(len(old), FADE)
    share, rows = np.arange(1, n + 1)[:, None] / (n + 1), new.copy()
    rows[:n] = (1.0 - share) * old[:n] + share * new[:n]
    return rows


def load_controller(
    checkpoint: str | Path | None = None, seed: int = 0, *, without_rules: Collection[str] = ()
) -> ControllerDiffusion:
    """Return the controller of a checkpoint, by default of the shipped one, if any.

    Raises:
        CheckpointError: There is no checkpoint, or the checkpoint does not fit.
    """
    config, sampler = _loaded(CHECKPOINTS.chosen(checkpoint))
    return ControllerDiffusion(config, sampler, seed, without_rules=without_rules)


@kept
def _loaded(path: Path) -> tuple[PolicyConfig, Sampler]:
    policy = CHECKPOINTS.load(path)
    return policy.config, Sampler(policy)


def make(setup: PolicySetup) -> ControllerDiffusion:
    """Return the controller of the checkpoint in its setup; errors are those of a load."""
    return load_controller(setup.checkpoint, setup.seed, without_rules=setup.without_rules)


def make_alone(setup: PolicySetup) -> ControllerDiffusion:
    """Return the same without the rules."""
    return load_controller(setup.checkpoint, setup.seed, without_rules=RULES)
