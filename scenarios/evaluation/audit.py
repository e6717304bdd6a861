"""Check what people said: was it obeyed if it should be, and refused if it must not be?"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from scenarios.evaluation.case import Case
from scenarios.recording.recorder import load
from scenarios.suites import Saying


@dataclass(frozen=True, kw_only=True)
class AuditLine:
    """The outcome of one saying of one condition, over all patients.

    Attributes:
        heard: number of episodes in which it was said before the end.
        right: number of these in which exactly its meaning was obeyed, or nothing if nothing
            should be.
        reply: the first reply, as an example.
    """

    condition: str
    saying: Saying
    heard: int
    right: int
    reply: str


def audit(folder: Path, cases: Iterable[Case]) -> tuple[AuditLine, ...]:
    """Read the recordings of one arm's cases; return nothing if nobody says anything in them."""
    found: dict[tuple[str, Saying], list[dict[str, Any]]] = {}
    for case in cases:
        answers = _answers(folder / case.recording) if case.condition.said else {}
        for saying in case.condition.said:
            given = found.setdefault((case.condition.name, saying), [])
            given += [answers[saying.text]] if saying.text in answers else []
    return tuple(
        AuditLine(
            condition=condition,
            saying=saying,
            heard=len(given),
            right=sum(_obeyed(answer) == saying.means for answer in given),
            reply=given[0]["reply"] if given else "",
        )
        for (condition, saying), given in found.items()
    )


def _answers(recording: Path) -> dict[str, dict[str, Any]]:
    """Return the recorded answer to each text."""
    return {heard["text"]: heard for heard in load(recording, steps=False).heard}


def _obeyed(answer: dict[str, Any]) -> str | None:
    return answer["command"] if answer["instruction"] is not None else None
