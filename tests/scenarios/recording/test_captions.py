"""Tests of captions: a band of one size, whose words are drawn and change with what is said."""

from dataclasses import replace

import numpy as np
import pytest

from planner.instruction import CORRECTIONS, TASKS, Assessment, Instruction
from scenarios.recording.captions import RECENT_S, captioned
from scenarios.recording.event_log import EpisodeStatus, LogLine

PICTURE = np.full((48, 640, 3), 90, np.uint8)
ASKED = Instruction(task=TASKS[1])
CALLED = replace(ASKED, hold=True, call=True, remark="The duct looks 9.1 mm long.")
JUDGED = Assessment(progress=0.4, failure_chance=0.03, alarm=False)
STATUS = EpisodeStatus(time_s=12.0, instruction=ASKED)
INJURED = LogLine(time_s=11.0, kind="injury", text="leak", detail="1, limit 0")


def band(status: EpisodeStatus) -> np.ndarray:
    made = captioned(PICTURE, status)
    assert np.array_equal(made[: len(PICTURE)], PICTURE)
    return made[len(PICTURE) :]


def test_the_band_has_one_size_and_is_empty_before_anything_is_said() -> None:
    assert not band(EpisodeStatus()).any()
    assert band(STATUS).any()
    assert band(STATUS).shape == band(EpisodeStatus()).shape
    assert band(replace(STATUS, lines=(INJURED,) * 30)).shape == band(EpisodeStatus()).shape


@pytest.mark.parametrize(
    "other",
    [
        replace(STATUS, time_s=13.0),
        replace(STATUS, exchange=True),
        replace(STATUS, instruction=replace(ASKED, source="human")),
        replace(STATUS, instruction=replace(ASKED, correction=CORRECTIONS[0])),
        replace(STATUS, instruction=CALLED),
        replace(STATUS, instruction=replace(ASKED, assessment=JUDGED)),
        replace(STATUS, lines=(INJURED,)),
    ],
)
def test_whatever_is_said_or_happens_is_seen(other: EpisodeStatus) -> None:
    assert not np.array_equal(band(other), band(STATUS))


def test_an_alarm_is_seen_and_the_planners_lines_are_not_told_twice() -> None:
    judged = replace(STATUS, instruction=replace(ASKED, assessment=JUDGED))
    alarmed = replace(ASKED, assessment=replace(JUDGED, alarm=True))
    assert not np.array_equal(band(replace(STATUS, instruction=alarmed)), band(judged))
    said = LogLine(time_s=11.0, kind="planner", text=ASKED.text)
    assert np.array_equal(band(replace(STATUS, lines=(said,))), band(STATUS))


def test_what_happened_long_ago_is_not_shown() -> None:
    old = replace(INJURED, time_s=STATUS.time_s - RECENT_S - 0.1)
    assert np.array_equal(band(replace(STATUS, lines=(old,))), band(STATUS))
