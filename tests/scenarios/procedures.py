"""Runs an episode and keeps everything that can be observed of it."""

import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.results import EpisodeResult
from scenarios.loop.step import Step
from scenarios.recording.attempt import attempt_episode
from scenarios.recording.recorder import Recording, load
from scenarios.run_episode import anatomy_of
from tests.made_once import MadeOnce
from tissue_sim.world import World

ROOT = Path(__file__).parents[2]
SEED_BY_COMMAND = 10_003


@dataclass(kw_only=True)
class StepKeeper:
    """Keeps every step of an episode."""

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
    file: Path
    recording: Recording
    world: World  # as it was in the end


def run(config: EpisodeConfig, out: Path) -> Procedure:
    recorder = StepKeeper()
    result = attempt_episode(config, out, [recorder]).result
    file = out / "episodes" / f"{config.seed}.npz"
    assert recorder.world is not None
    return Procedure(
        result=result,
        steps=recorder.steps,
        file=file,
        recording=load(file),
        world=recorder.world,
    )


def run_by_command(out: Path) -> tuple[Path, subprocess.CompletedProcess[str]]:
    """Call `calot run` with its own choice of policies; return its folder and its output."""
    words = ["--seed", str(SEED_BY_COMMAND), "--scenario", "textbook"]
    return out, subprocess.run(
        [sys.executable, "-m", "scenarios.cli", "run", *words, "--out", str(out)],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )


def run_once(config: EpisodeConfig, name: str, made_once: MadeOnce) -> Procedure:
    """Run an episode in one worker; other workers read its steps, its end and its recording."""

    def make(out):
        ran = run(config, out)
        return ran.result, ran.steps, ran.file, ran.world.state()

    result, steps, file, state = made_once(name, make)
    world = World()
    world.reset(anatomy_of(config))
    world.restore(state)
    return Procedure(result=result, steps=steps, file=file, recording=load(file), world=world)
