"""A table of a report, for the terminal and for the page."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rich.table import Table as DrawnTable

from scenarios.files.outside_text import table_of


@dataclass(frozen=True, kw_only=True)
class Cell:
    """A cell of a table that is more than a text.

    Attributes:
        remark: A softer text after it.
        share: The share that the text states, 0 to 1; a page draws it.
    """

    text: str
    remark: str = ""
    share: float | None = None

    def __str__(self) -> str:
        return f"{self.text} ({self.remark})" if self.remark else self.text


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table.

    Attributes:
        words, numbers: Headings of the columns of words, and of the columns of numbers after them.
        page_only: Whether the terminal leaves it out.
    """

    title: str
    words: Sequence[str]
    numbers: Sequence[str]
    rows: Sequence[Sequence[str | Cell]]
    page_only: bool = False

    def drawn(self) -> DrawnTable:
        """Return the table as the terminal draws it."""
        rows = ([*map(str, row)] for row in self.rows)
        return table_of(self.title, self.words, self.numbers, rows)


Columns = Mapping[str, Callable[[Any], str | Cell]]
"""By heading: what makes an item's cell."""


def tabulate(
    title: str, words: Columns, numbers: Columns, items: Iterable[Any], page_only: bool = False
) -> Table:
    """Return a table with one row for each item."""
    cells = [*words.values(), *numbers.values()]
    return Table(
        title=title,
        words=tuple(words),
        numbers=tuple(numbers),
        rows=[[cell(item) for cell in cells] for item in items],
        page_only=page_only,
    )
