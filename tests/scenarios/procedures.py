"""Runs an episode and keeps everything that can be seen of it."""

from dataclasses import dataclass, field
from pathlib import Path

from scenarios.episode import Step
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.results import EpisodeResult
from scenarios.recording.attempt import attempt_episode
from scenarios.recording.recorder import Recording, load
from tissue_sim.world import World


@dataclass(kw_only=True)
class Witness:
    """Remembers every step."""

    world: World | None = None
    steps: list[Step] = field(default_factory=list)

    def on_reset(self, world: World) -> None:
        self.world = world

    def on_step(self, step: Step) -> None:
        self.steps.append(step)

    def on_end(self, result: EpisodeResult) -> None:
        pass


@dataclass(frozen=True, kw_only=True)
class Procedure:
    result: EpisodeResult
    steps: list[Step]
    recording: Recording
    world: World  # as it was in the end


def run(config: EpisodeConfig, out: Path) -> Procedure:
    witness = Witness()
    result = attempt_episode(config, out, [witness])
    recording = load(out / "episodes" / f"{config.seed}.npz")
    assert witness.world is not None
    return Procedure(result=result, steps=witness.steps, recording=recording, world=witness.world)
