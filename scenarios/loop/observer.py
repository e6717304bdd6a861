"""The interface of observers of an episode, and the one that shows progress on the terminal.

Other observers are the recorder, the video and the viewer.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol, Self

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from planner.procedure.cholecystectomy import CHOLECYSTECTOMY
from planner.procedure.procedure import Procedure
from scenarios.files.outside_text import visible
from scenarios.loop.results import EpisodeResult

if TYPE_CHECKING:  # both are heavy to import
    from scenarios.loop.step import Step
    from tissue_sim.world import World


class Observer(Protocol):
    """Observes an episode and changes nothing in it; a subclass need not observe everything.

    An observer whose attribute `needs_images` is true gets a world with cameras.
    """

    def on_reset(self, world: World) -> None:
        """Observe the world before anything moves."""

    def on_step(self, step: Step) -> None:
        """Observe one finished control step."""

    def on_end(self, result: EpisodeResult) -> None:
        """Observe the result; not called if the episode broke off."""


class ProgressDisplay:
    """A bar over the episodes and, as an observer of an episode, a bar over its tasks."""

    def __init__(
        self, episodes: int, console: Console, procedure: Procedure = CHOLECYSTECTOMY
    ) -> None:
        self._procedure = procedure
        self._progress = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            TextColumn("{task.fields[detail]}", markup=False),
            console=console,
            transient=True,
        )
        self._episodes = self._progress.add_task("episodes", total=episodes, detail="")
        self._tasks = self._progress.add_task("tasks", detail="", visible=False)

    def __enter__(self) -> Self:
        self._progress.start()
        return self

    def __exit__(self, *exception: object) -> None:
        self._progress.stop()

    def on_reset(self, world: Any) -> None:
        """Restart the bar over the patient's tasks."""
        total = len(self._procedure.tasks_with(world.anatomy.tubes))
        self._progress.reset(self._tasks, total=total, detail="ready", visible=True)

    def on_step(self, step: Any) -> None:
        """Show the task, the simulated time, the words and replies, and the outcomes of orders."""
        for heard in step.heard:
            self._say(f"{heard.time_s:.1f} s, {heard.text!r}: {heard.reply}")
        for told in step.told:
            self._say(f"{step.time_s:.1f} s: {told}")
        why = f" ({step.instruction.remark})" if step.instruction.remark else ""
        said = f"{step.instruction.text}{why}"
        self._progress.update(
            self._tasks,
            completed=step.instruction.task.index - 1,
            detail=visible(f"{' '.join(said.split())}, {step.time_s:.1f} s simulated"),
        )

    def on_end(self, result: EpisodeResult) -> None:
        """Fill the bar with the tasks that were done."""
        self._progress.update(self._tasks, completed=sum(task.is_over for task in result.tasks))

    def advance(self) -> None:
        """Count one finished episode."""
        self._progress.advance(self._episodes)

    def _say(self, line: str) -> None:
        self._progress.console.print(visible(line), highlight=False, markup=False, soft_wrap=True)
