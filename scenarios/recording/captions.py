"""Draw the instructions and their reasons in a band below the endoscope's picture."""

from __future__ import annotations

from functools import cache
from textwrap import wrap

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from planner.instruction import Instruction
from scenarios.files.outside_text import visible
from scenarios.recording.event_log import EpisodeStatus, Kind, LogLine

TEXT_PX, LINE_PX, MARGIN_PX = 14, 19, 10
LINES = 6  # of the band: speaker and instruction, progress, and the newest events
RECENT_S = 10.0  # older events are not shown
WIDE = 92  # letters of a line that is 640 pixels wide
WHITE, SOFT = (240, 240, 240), (165, 165, 165)
COLOURS: dict[Kind, tuple[int, int, int]] = {
    "human": (255, 225, 120), "said": (255, 225, 120), "asked back": (255, 225, 120),
    "told": (130, 220, 255), "injury": (255, 120, 110), "disturbance": (255, 170, 90),
    "end": WHITE,
}  # fmt: skip


def captioned(picture: NDArray[np.uint8], status: EpisodeStatus) -> NDArray[np.uint8]:
    """Return the picture (height, width, 3) with a band of the same width below it.

    The band is empty before the first instruction: all pictures of a video have one size.
    """
    width = picture.shape[1]
    band = Image.new("RGB", (width, LINES * LINE_PX + 2 * MARGIN_PX))
    if status.instruction is not None:
        draw, at = ImageDraw.Draw(band), MARGIN_PX
        for text, colour in _lines(status, status.instruction)[:LINES]:
            draw.text((MARGIN_PX, at), text, fill=colour, font=_font())
            at += LINE_PX
    return np.concatenate([picture, np.asarray(band)])


def _lines(status: EpisodeStatus, now: Instruction) -> list[tuple[str, tuple[int, int, int]]]:
    """Return the band's lines and their colours."""
    who = "a person" if now.source == "human" else "planner"
    doing = "the nurse has the right arm" if status.exchange else f"{who}: {now.text}"
    if now.correction is not None:
        doing += f"   (task: {now.task.text})"
    said = [(f"{status.time_s:.1f} s   {doing}", WHITE)]
    said += [(line, WHITE) for line in wrap(visible(now.remark), WIDE)]
    if (judged := now.assessment) is not None:
        alarm = "   ALARM" if judged.alarm else ""
        chance = f"chance of failure {judged.failure_chance:.0%}"
        said.append((f"task {judged.progress:.0%} done, {chance}{alarm}", SOFT))
    since_s = status.time_s - RECENT_S
    for event in reversed(status.lines):
        if event.kind == "planner" or event.time_s < since_s:
            continue
        said += [(line, COLOURS.get(event.kind, SOFT)) for line in wrap(_words(event), WIDE)]
    return said


def _words(event: LogLine) -> str:
    """Return an event in words."""
    detail = f": {event.detail}" if event.detail else ""
    return visible(f"{event.time_s:.1f} s   {event.kind}: {event.text}{detail}")


@cache
def _font() -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    return ImageFont.load_default(TEXT_PX)
