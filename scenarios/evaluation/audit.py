"""What came of what people said: obeyed where it should be, refused where it must not."""

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
    """One saying of one condition, over all patients.

    Attributes:
        heard: in how many episodes it was said before the end.
        right: in how many of these just what it means was obeyed, or nothing where it should not.
        reply: the first, as an example.
    """

    condition: str
    saying: Saying
    heard: int
    right: int
    reply: str


def audit(folder: Path, cases: Iterable[Case]) -> tuple[AuditLine, ...]:
    """From the recordings of cases of one arm; empty where nothing is said in them."""
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
    """What came of each text."""
    return {heard["text"]: heard for heard in load(recording, steps=False).heard}


def _obeyed(answer: dict[str, Any]) -> str | None:
    return answer["command"] if answer["instruction"] is not None else None
