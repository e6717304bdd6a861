"""The score of a set by classes: `python -m tests.planner.language.by_class SET.tsv ...`."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence

from planner.language.interpreter import Interpreter
from planner.language.reading import Reading
from planner.language.sentence_sets import Row, holds, keeps_the_protocol, rows_named
from tests.planner.language.scoring import is_right, read_as

_BEGINS = {
    "hold: ": "prohibitions",
    "allow: ": "permissions",
    "question: ": "questions",
    "refuse": "dangerous",
    "none": "harmless",
    "ask": "ask",
    "resume": "resumptions",
}
_HARMLESS = ("refuse", "ask", "none")


def class_of(row: Row) -> str:
    """Return the class of a sentence by what it means."""
    if row.latest:
        return "after"
    if row.expected == "hold" or (holds(row.expected.split(": ")[0]) and ": " not in row.expected):
        return "warnings"
    begins = (name for start, name in _BEGINS.items() if row.expected.startswith(start))
    moves = row.expected.startswith("move ") and " ; " not in row.expected
    return next(begins, "corrections" if moves else "tasks")


def scored(rows: Sequence[Row], read: Callable[[str], Reading]) -> list[str]:
    """Return the lines of a table: class, sentences, right, misread, held in vain, wrong ones."""
    of_class, wrong = defaultdict(list), list[str]()
    for row in rows:
        written = read_as(row, read)
        of_class[class_of(row)].append((row, written))
        if not is_right(row.expected, written):
            wrong.append(f"{class_of(row):12} {row.sentence!r}: {row.expected!r} as {written!r}")
    table = [_line(name, read_rows) for name, read_rows in sorted(of_class.items())]
    return [*wrong, *table, _line("all", [one for ones in of_class.values() for one in ones])]


def _line(name: str, read: Sequence[tuple[Row, str]]) -> str:
    right = sum(is_right(row.expected, written) for row, written in read)
    wrong = [(row, written) for row, written in read if not is_right(row.expected, written)]
    misread = sum(written not in _HARMLESS and not holds(written) for _, written in wrong)
    missed = sum(holds(row.expected) and not holds(written) for row, written in read)
    held = sum(holds(written) and not holds(row.expected) for row, written in read)
    return (
        f"{name:13} {len(read):4} right {right:4} ({100 * right / len(read):3.0f} %)"
        f"  misread {misread:3}  warnings missed {missed:3}  held in vain {held:3}"
    )


if __name__ == "__main__":
    import sys

    named = rows_named(sys.argv[1:], "tests.planner.language.by_class", keeps_the_protocol)
    print("\n".join(scored(named, Interpreter().read)))
