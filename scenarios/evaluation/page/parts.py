"""Building blocks of the sections of a report's page."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from scenarios.evaluation.page.sheet import N_COLOURS
from scenarios.evaluation.report import Report
from scenarios.files.outside_text import in_html


def section(title: str, text: str, body: str) -> str:
    """Return a section; an empty text if `body` is empty."""
    return f"<section><h2>{title}</h2><p class='soft'>{text}</p>{body}</section>" if body else ""


def table(head: Sequence[str], names: int, rows: Iterable[Sequence[str]]) -> str:
    """Return a table of HTML cells; the first `names` columns are words, the others numbers."""
    body = "".join(
        "<tr>" + "".join(_cell("td", cell, k >= names) for k, cell in enumerate(row)) + "</tr>"
        for row in rows
    )
    top = "".join(_cell("th", cell, k >= names) for k, cell in enumerate(head))
    whole = f"<table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>"
    return f"<div class='scroll'>{whole}</div>" if body else ""


def folded(title: str, body: str) -> str:
    """Return content that shows when its title is pressed; an empty text if `body` is empty."""
    return f"<details><summary>{title}</summary>{body}</details>" if body else ""


def _cell(tag: str, content: str, is_number: bool) -> str:
    kind = " class='n'" if is_number else ""
    return f"<{tag}{kind}>{content}</{tag}>"


def legend(report: Report) -> str:
    return "".join(arm_name(k, arm) + " &emsp; " for k, arm in enumerate(report.arms))


def arm_name(k: int, name: str) -> str:
    dot = f"<span class='dot arm{k % N_COLOURS}'></span>"
    return f"<span class='arm-name'>{dot}{in_html(name)}</span>"
