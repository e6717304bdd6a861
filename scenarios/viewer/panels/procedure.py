"""What the robot does now, and the 17 tasks with how far they are."""

from __future__ import annotations

from html import escape

import viser

from planner.instruction import TASKS, Instruction, Task
from scenarios.viewer.event_log import Story, progress_of, verdict
from scenarios.viewer.session_state import Asks, State
from tissue_sim.tools.arms import LEFT_ARM

_PLANNER, _HUMAN = "#1c7ed6", "#e8590c"


class ProcedurePanel:
    """The instruction in large, a bar, and the list."""

    def __init__(self, gui: viser.GuiApi, ask: Asks) -> None:
        del ask
        self._now = gui.add_html("")
        self._bar = gui.add_progress_bar(0.0, color="green")
        self._tasks = gui.add_html("")

    def update(self, state: State) -> None:
        """Show how far it is."""
        story = state.story
        self._now.content = f'<div class="calot">{_now(story, state.paused)}</div>'
        self._bar.value = 100.0 * progress_of(story)
        rows = "".join(_row(task, story) for task in TASKS)
        self._tasks.content = f'<div class="calot"><table>{rows}</table></div>'


def _now(story: Story, paused: bool) -> str:
    clock = f'<span class="dim">{story.time_s:.1f} s</span>'
    if story.result is not None:
        return f'<div class="now">{escape(verdict(story.result).capitalize())}</div>{clock}'
    if story.instruction is None:
        return '<div class="now">Ready: press Start</div>the patient lies on the table'
    said = story.instruction
    state = " · paused" if paused else " · the nurse has the right arm" if story.exchange else ""
    led = "" if story.hand is None else _led(story.hand)
    return f'<div class="now">{escape(said.text)}</div>{_source(said)} {clock}{state}{led}'


def _source(said: Instruction) -> str:
    colour = _HUMAN if said.source == "human" else _PLANNER
    who = "you" if said.source == "human" else "planner"
    sure = f"{said.confidence:.0%} sure"
    return f'<span class="tag" style="background: {colour}">{who}</span> {sure} ·'


def _led(arm: int) -> str:
    side = "left" if arm == LEFT_ARM else "right"
    return f'<br><span class="tag" style="background: {_HUMAN}">you lead the {side} arm</span>'


def _row(task: Task, story: Story) -> str:
    progress = story.tasks.get(task.index)
    under_way = story.instruction is not None and story.instruction.task == task
    mark = "▶" if under_way else "✓" if progress and progress.done else "·"
    state = "now" if under_way else "" if progress else "todo"
    time = f"{progress.time_s:.1f} s" if progress else ""
    helped = f" · corrected {progress.corrections} ×" if progress and progress.corrections else ""
    return (
        f'<tr class="{state}"><td>{mark}</td><td>{escape(task.text)}{helped}</td>'
        f'<td class="number">{time}</td></tr>'
    )
