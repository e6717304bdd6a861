"""Panels that show the procedure: instruction, progress of the tasks, endoscope's picture."""

from __future__ import annotations

import numpy as np
import viser

from planner.instruction import Instruction, Task
from scenarios.catalogue import procedure_named
from scenarios.files.outside_text import in_html
from scenarios.recording.event_log import EpisodeStatus, progress_of
from scenarios.recording.reasons import in_detail
from scenarios.viewer.panels.panel import Panel
from scenarios.viewer.session_state import Asks, SessionState, State
from tissue_sim.tools.arms import LEFT_ARM

_PLANNER, _HUMAN, _FORBIDDEN = "#1c7ed6", "#e8590c", "#c92a2a"


class ProcedurePanel(Panel):
    """The instruction in large type, a progress bar, and the list of tasks."""

    def __init__(self, gui: viser.GuiApi, ask: Asks) -> None:
        del ask
        self._now = gui.add_html("")
        self._bar = gui.add_progress_bar(0.0, color="green")
        self._tasks = gui.add_html("")

    def update(self, state: State) -> None:
        """Show the progress."""
        status, procedure = state.status, procedure_named(state.config.procedure)
        self._now.content = f'<div class="calot">{_now(status, state.paused)}</div>'
        self._bar.value = 100.0 * progress_of(status, procedure)
        rows = "".join(_row(task, status) for task in procedure.tasks)
        self._tasks.content = f'<div class="calot"><table>{rows}</table></div>'


class CameraPanel(Panel):
    """The endoscope's picture, a few times a second, if pictures are rendered."""

    def __init__(self, gui: viser.GuiApi, ask: Asks) -> None:
        self._image = gui.add_image(
            np.zeros((3, 4, 3), np.uint8), label="endoscope", visible=ask(SessionState.state).camera
        )

    def update(self, state: State) -> None:
        """Show the newest picture."""
        if state.picture is not None:
            self._image.image = state.picture


def _now(status: EpisodeStatus, paused: bool) -> str:
    clock = f'<span class="dim">{status.time_s:.1f} s</span>'
    if status.result is not None:
        ended = in_detail(status.result)
        return f'<div class="now">{in_html(ended[:1].upper() + ended[1:])}</div>{clock}'
    if status.instruction is None:
        return '<div class="now">Ready: press Start</div>the patient lies on the table'
    instruction = status.instruction
    state = " · paused" if paused else " · the nurse has the right arm" if status.exchange else ""
    guided = "" if status.guided_arm is None else _guided(status.guided_arm)
    now = f'<div class="now">{in_html(instruction.text)}</div>{_source(instruction)}'
    return f"{now} {clock}{state}{guided}{_limits(instruction)}"


def _source(instruction: Instruction) -> str:
    colour = _HUMAN if instruction.source == "human" else _PLANNER
    who = "you" if instruction.source == "human" else "planner"
    sure = f"{instruction.confidence:.0%} sure"
    return f'<span class="tag" style="background: {colour}">{who}</span> {sure} ·'


def _limits(instruction: Instruction) -> str:
    """Return a person's prohibitions, the reason of a hold, and the speed of the arms."""
    told = [f"forbidden: {act}" for act in instruction.forbidden]
    told += [instruction.remark] if instruction.hold and instruction.remark else []
    told += [f"speed {instruction.speed:.0%}"] if instruction.speed != 1.0 else []
    return "".join(
        f'<br><span class="tag" style="background: {_FORBIDDEN}">{in_html(one)}</span>'
        for one in told
    )


def _guided(arm: int) -> str:
    side = "left" if arm == LEFT_ARM else "right"
    return f'<br><span class="tag" style="background: {_HUMAN}">you guide the {side} arm</span>'


def _row(task: Task, status: EpisodeStatus) -> str:
    progress = status.tasks.get(task.index)
    under_way = status.instruction is not None and status.instruction.task == task
    mark = "▶" if under_way else "✓" if progress and progress.done else "·"
    state = "now" if under_way else "" if progress else "todo"
    time = f"{progress.time_s:.1f} s" if progress else ""
    corrected = (
        f" · corrected {progress.corrections} ×" if progress and progress.corrections else ""
    )
    return (
        f'<tr class="{state}"><td>{mark}</td><td>{in_html(task.text)}{corrected}</td>'
        f'<td class="number">{time}</td></tr>'
    )
