"""The section with people's words, and how often they were rightly obeyed or refused."""

from __future__ import annotations

from scenarios.evaluation.audit import AuditLine
from scenarios.evaluation.page.parts import section, table
from scenarios.evaluation.report import Report
from scenarios.evaluation.words import NOTHING
from scenarios.files.outside_text import in_html


def language(report: Report) -> str:
    lines = {
        (line.condition, line.saying): line
        for found in report.arms.values()
        for suite in found.suites.values()
        for line in suite.audit
    }
    rights = [
        {(line.condition, line.saying): line for s in found.suites.values() for line in s.audit}
        for found in report.arms.values()
    ]
    rows = []
    for key, line in lines.items():
        cells = [
            cell
            for arm in rights
            for cell in (_cells(arm[key]) if key in arm else (NOTHING, NOTHING))
        ]
        meant = in_html(line.saying.means or "nothing")
        said = f"“{in_html(line.saying.text)}”<br><span class='soft'>{in_html(line.reply)}</span>"
        rows.append((in_html(line.condition), said, meant, *cells))
    arms = [cell for arm in report.arms for cell in (in_html(arm), "orders settled")]
    head = ("kind", "said, and replied", "should move", *arms)
    return section(
        "What people say",
        "Said at set times in the procedure. Right is: obeyed as meant, or refused or asked back"
        " where nothing should move. An order is settled when it is carried out, or the person is"
        " told why it is not, before something else is said.",
        table(head, 3, rows),
    )


def _cells(line: AuditLine) -> tuple[str, str]:
    settled = _right(line.settled, line.ordered) if line.ordered else NOTHING
    return _right(line.right, line.heard), settled


def _right(right: int, heard: int) -> str:
    return f"<span class='{'good' if right == heard else 'bad'}'>{right} of {heard}</span>"
