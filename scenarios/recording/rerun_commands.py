"""Run a recorded episode's commands through the world again, to recover the tissue.

A recording holds commands and arm motions, not the tissue. The world is deterministic: the same
commands on the same patient, disturbed in the same way, move the same tissue. Identical arms,
forces, injuries and judgements, bit for bit, show this.
"""

from __future__ import annotations

from collections.abc import Iterator, Set
from dataclasses import replace

import msgspec

from planner.procedure.outcomes import is_needed, structure_of
from planner.procedure.procedure import Procedure
from scenarios.catalogue import PROCEDURES, procedure_named
from scenarios.files.errors import describe_error
from scenarios.files.strict_json import plain
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.perturbation.effects import Effects
from scenarios.perturbation.perturbations import MANUAL
from scenarios.recording.recorder import Recording, recomputed
from scenarios.run_episode import anatomy_of, judge
from tissue_sim.tools.arms import JointCommand
from tissue_sim.tools.instruments import right_tools
from tissue_sim.world import World


class CommandRerun:
    """One recording and the world that replays its commands.

    Attributes:
        world: The patient on the table, before the first step.
        n_steps: Number of steps.
    """

    def __init__(self, recording: Recording, allowed: Set[str] | None = frozenset()) -> None:
        """Put the patient on the table.

        Args:
            recording: The recording.
            allowed: Procedures from outside that may be imported; None for any.

        Raises:
            ValueError: The recording is of another version, which has other options or patients.
                Or its procedure is not allowed, or is another one now.
        """
        self._recording, self._config = recording, config_of(recording)
        self._procedure = _procedure_of(recording, self._config.procedure, allowed)
        self.n_steps = len(recording.arrays["time_s"])
        self.world = World()
        self._effects = Effects(self._config.perturbations, self._config.seed)
        self.world.reset(self._effects.on_anatomy(anatomy_of(self._config)))
        if recording.anatomy is not None and plain(self.world.anatomy) != recording.anatomy:
            raise ValueError(
                f"seed {self._config.seed} is another patient now than in the recording,"
                f" which was made with {recording.versions}"
            )

    def steps(self) -> Iterator[tuple[str, ...]]:
        """Run the steps; after each, yield the fields that differ from the recording, to the bit.

        After the last step the result is compared, too. An error of the world ends the steps.
        """
        for k in range(self.n_steps):
            try:
                unlike = self._step(k)
                if k == self.n_steps - 1:
                    unlike = (*unlike, *self._unlike_result())
            except (ArithmeticError, ValueError) as error:
                yield (describe_error(error),)
                return
            yield unlike

    def _step(self, k: int) -> tuple[str, ...]:
        """Run step `k`; return the names of the fields that differ from the recording."""
        arrays, world = self._recording.arrays, self.world
        words = self._recording.instructions[arrays["instruction"][k]]
        task = self._procedure.task(words["task"])
        if self._nurse_came(k):
            world.equip(_right_tool(arrays["right_tool"][k]))
        for name, magnitude in self._manual(k):
            self._effects.add(replace(MANUAL[name], magnitude=magnitude))
        n_before = len(world.record.injuries)
        self._effects.before_step(world, task)
        command = JointCommand(joints=arrays["commands"][k])
        exact = world.step(command, intended=structure_of(task, world))
        now = recomputed(exact)
        unlike = [name for name in now if now[name].tobytes() != arrays[name][k].tobytes()]
        injuries = [{"step": k, **plain(injury)} for injury in world.record.injuries[n_before:]]
        noted = [e for e in self._recording.events if e["step"] == k]
        return (*unlike, *(["events"] if injuries != noted else []))

    def _unlike_result(self) -> list[str]:
        """Return the parts of the recorded result that the patient contradicts."""
        if (result := self._recording.result) is None:
            return []
        done = {task["index"] for task in result["tasks"] if task["success"]}
        needed = {t.index for t in self._procedure.tasks if is_needed(t, self.world)}
        judged = plain(judge(self.world, complete=done >= needed))
        return [f"result, {name}" for name in judged if judged[name] != result.get(name)]

    def _nurse_came(self, k: int) -> bool:
        """Return whether a tool was exchanged or a clip loaded before this step."""
        tool, loaded = self._recording.arrays["right_tool"], self._recording.arrays["clip_loaded"]
        tool_before, loaded_before = (tool[k - 1], loaded[k - 1]) if k else (0, 1)
        return bool(tool[k] != tool_before or loaded[k] > loaded_before)

    def _manual(self, k: int) -> list[tuple[str, float]]:
        """Return the perturbations, with magnitudes, that a person caused at this step."""
        return [
            (p["name"], p["magnitude"])
            for p in self._recording.perturbations
            if p["step"] == k and p["name"] in MANUAL
        ]


def _procedure_of(recording: Recording, name: str, allowed: Set[str] | None) -> Procedure:
    """Return the procedure of a recording.

    Raises:
        ValueError: The procedure is from outside and not allowed, or lacks an instructed task.
    """
    if name not in PROCEDURES and allowed is not None and name not in allowed:
        raise ValueError(f"it names the procedure {name!r}, which is code: give --procedure {name}")
    procedure = procedure_named(name)
    for words in recording.instructions:
        procedure.task(words["task"])
    return procedure


def _right_tool(number: int) -> str:
    """Return the tool that a recording numbers.

    Raises:
        ValueError: There is no such tool here.
    """
    if number >= len(tools := right_tools()):
        raise ValueError(f"there is no right tool {number}; allowed: 0 to {len(tools) - 1}")
    return tools[number]


def config_of(recording: Recording) -> EpisodeConfig:
    """Return the configuration of a recording.

    Raises:
        ValueError: This version does not know the configuration.
    """
    try:
        made = msgspec.convert(recording.config, EpisodeConfig)
    except ValueError as error:
        raise ValueError(f"its configuration is of another version: {error}") from None
    if unknown := recording.config.keys() - vars(made).keys():
        names = ", ".join(sorted(unknown))
        raise ValueError(f"its configuration is of another version: it has {names}")
    return made
