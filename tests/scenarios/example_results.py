"""Results of five episodes: one passed, one failed, two were called, one ended in an error."""

import json
from dataclasses import replace
from pathlib import Path

import msgspec

from scenarios.loop.results import (
    CallResult,
    EpisodeResult,
    InjuryResult,
    PeakResult,
    SafetyResult,
    TaskResult,
)

PASSED = EpisodeResult(
    scenario="nominal",
    seed=20_000,
    planner="scripted",
    controller="expert",
    success=True,
    tasks=(
        TaskResult(
            index=1, instruction="grabbing gallbladder", success=True, time_s=9.5, corrections=2
        ),
    ),
    procedure_time_s=301.2,
    exchange_time_s=40.0,
    wall_s=62.0,
    corrections=2,
    peaks=(
        PeakResult(event="pinch", value=3.1, limit=37.0),
        PeakResult(event="cuff", value=0.0012, limit=0.001, at_least=True),
    ),
    safety=SafetyResult(interventions=3, min_clearance_m=0.0012),
    anatomy_hash="0123456789ab",
)
FAILED = replace(
    PASSED,
    seed=20_001,
    success=False,
    injuries=(InjuryResult(event="pinch", time_s=12.0, value=41.0, limit=37.0),),
    peaks=(PeakResult(event="pinch", value=41.0, limit=37.0),),
)
CALLED = replace(
    PASSED,
    seed=20_003,
    success=False,
    call=CallResult(reason="The duct is 9.0 mm long.", in_time=True, needed=True),
    tasks=(),
)
NEEDLESS = replace(CALLED, call=CallResult(reason="I am unsure.", in_time=True, needed=False))
ERROR = replace(PASSED, seed=20_002, success=False, error="ValueError: no such thing", tasks=())


def read_results(path: Path) -> tuple[EpisodeResult, ...]:
    """Return the episodes of a results.json."""
    return tuple(
        msgspec.convert(entry, EpisodeResult) for entry in json.loads(path.read_text())["episodes"]
    )
