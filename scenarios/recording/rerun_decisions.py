"""Run a recorded episode again from the start: policies decide again, people act as recorded."""

from __future__ import annotations

from collections.abc import Iterator, Set
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from planner.chat_endpoint import endpoint_from_environment
from planner.command import COMMANDS
from scenarios.catalogue import policy_named, procedure_named
from scenarios.files.errors import describe_error
from scenarios.loop.episode_config import EpisodeConfig, checkpoint_digests
from scenarios.loop.observer import Observer
from scenarios.loop.person.guided_arm import GuidedArm
from scenarios.loop.person.inbox import Inbox
from scenarios.loop.policies import require_factory
from scenarios.perturbation.perturbations import MANUAL
from scenarios.recording.attempt import attempt_episode
from scenarios.recording.recorder import Recording, load
from scenarios.recording.rerun_commands import config_of
from scenarios.recording.schema import NOTES
from tissue_sim.constants import WORLD_VERSION

if TYPE_CHECKING:
    from tissue_sim.world import World

INTERRUPTIONS = ("KeyboardInterrupt", "Restart")
"""Errors from outside the episode, which would have continued without them."""


class CutOffError(RuntimeError):
    """The error that ends a repeated episode where its recording breaks off."""


def repeat(recording: Recording, out: Path, allowed: Set[str] | None = frozenset()) -> Recording:
    """Run the episode again and record it in `out`; stop where the recording breaks off, if so.

    A policy MODULE:FACTORY of the recording must be `allowed`; None allows all.

    Raises:
        ValueError: The episode cannot be repeated here; the message says why.
    """
    config = _repeatable(recording, allowed)
    inbox = Inbox()
    attempt_episode(config, out, [_People(recording, inbox)], inbox)
    again = load(out / "episodes" / f"{config.seed}.npz")
    goes_on = (again.error or "").startswith(CutOffError.__name__)
    return _broken_off_as(recording, again) if goes_on else again


def _repeatable(recording: Recording, allowed: Set[str] | None) -> EpisodeConfig:
    """Return the recording's configuration; people's words are in the recording itself."""
    if recording.world_version != WORLD_VERSION:
        raise ValueError(
            f"made in world version {recording.world_version}, but here it is {WORLD_VERSION}"
        )
    config = replace(config_of(recording), instruct=None, person=None, act_limit_s=None)
    for role, name in config.outside.items():
        if allowed is not None and name not in allowed:
            raise ValueError(
                f"it names {name!r} as its {role}, which is code: give --{role} {name}, or --trust"
            )
        if role == "procedure":
            procedure_named(name)
        else:
            require_factory(name)
    if policy_named(config.planner).endpoint:
        endpoint_from_environment()
    if recording.checkpoints:  # none if the episode broke off before its reset
        _require_same_checkpoints(config, recording.checkpoints)
    return config


def _require_same_checkpoints(config: EpisodeConfig, recorded: dict[str, str]) -> None:
    try:
        here = checkpoint_digests(config)
    except OSError as error:
        raise ValueError(f"its checkpoint cannot be read: {describe_error(error)}") from None
    for role, digest in recorded.items():
        if (now := here.get(role, "of no file")) != digest:
            raise ValueError(
                f"the {role}'s checkpoint is another file now: SHA-256 {now[:12]}...,"
                f" but it was {digest[:12]}..."
            )


class _People(Observer):
    """Observes a repeated episode, and repeats people's recorded acts before each step."""

    def __init__(self, recording: Recording, inbox: Inbox) -> None:
        self._recording, self._inbox = recording, inbox
        self._n_steps = len(recording.arrays["time_s"])
        self._step = 0

    def on_reset(self, world: World) -> None:
        """Act before the first step."""
        self._act()

    def on_step(self, step: Any) -> None:
        """Act before the next step; stop where the recording breaks off, or should have ended."""
        goes_on = self._recording.result is not None
        if self._step == self._n_steps + goes_on:
            raise CutOffError("the recording ends here")
        self._step += 1
        self._act()

    def _act(self) -> None:
        for heard in self._now(self._recording.heard):
            if heard["by"] == "button":
                self._inbox.press(COMMANDS[heard["text"]])
            else:
                self._inbox.say(heard["text"])
        for applied in self._now(self._recording.perturbations):
            if applied["name"] in MANUAL:
                self._inbox.disturb(
                    replace(MANUAL[applied["name"]], magnitude=applied["magnitude"])
                )
        self._inbox.guided = None
        for hand in self._now(self._recording.hands):
            goal = np.array(hand["T_world_goal"])
            self._inbox.guided = GuidedArm(
                arm=hand["arm"], T_world_goal=goal, jaw_rad=hand["jaw_rad"]
            )

    def _now(self, entries: tuple[dict[str, Any], ...]) -> Iterator[dict[str, Any]]:
        return (entry for entry in entries if entry["step"] == self._step)


def _broken_off_as(recording: Recording, again: Recording) -> Recording:
    """Return the repeated episode cut to the recording's length, with the same interruption."""
    n = len(recording.arrays["time_s"])
    notes = {name: [e for e in getattr(again, name) if e["step"] < n] for name in NOTES}
    interrupted = (recording.error or "").startswith(INTERRUPTIONS)
    return replace(
        again,
        arrays={name: array[:n] for name, array in again.arrays.items()},
        **{name: tuple(entries) for name, entries in notes.items()},
        error=recording.error if interrupted else None,
    )
