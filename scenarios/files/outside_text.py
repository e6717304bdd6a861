"""Show text from outside, such as a model's answer or a person's words, as plain text only.

A terminal obeys escape sequences, rich obeys `[markup]`, a browser obeys tags, and both reverse
text at right-to-left marks. Every console of Calot is a `Terminal`; pages use `in_html`, or
`templates`, which escape.
Reports are printed on `output()`, most of their tables are made by `table_of`.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any
from unicodedata import category

from rich.console import Console
from rich.table import Table
from rich.text import Text

from scenarios.files.errors import silence

if TYPE_CHECKING:
    from jinja2 import Environment


def visible(text: str) -> str:
    r"""Return the text with control and invisible characters written out, as `\x1b`."""
    return "".join(map(_shown, text))


def in_html(text: str) -> str:
    """Return HTML that shows the text unchanged."""
    return escape(visible(text))


def templates(folder: Path) -> Environment:
    """Return a folder's Jinja templates; they show any string unchanged, as `in_html` does."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    return Environment(
        loader=FileSystemLoader(folder),
        autoescape=True,
        finalize=_written_out,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def _written_out(value: Any) -> Any:
    """Write out invisible characters of outside text, which Jinja then escapes."""
    return visible(value) if isinstance(value, str) and not hasattr(value, "__html__") else value


class Terminal(Console):
    """A console that shows any string unchanged; only Calot's own output is coloured.

    If no reader is left, the console falls silent; rich's own would exit with code 1.
    """

    def __init__(self, *, stderr: bool = False, width: int | None = None) -> None:
        super().__init__(stderr=stderr, width=width, markup=False, emoji=False, highlight=False)

    def render_str(self, text: str, **style: Any) -> Text:
        """Return a string, of a line or of a table, in its drawn form."""
        return super().render_str(visible(text), **style)

    def on_broken_pipe(self) -> None:
        """Stop writing."""
        self.quiet = True
        silence(self.file)


def _shown(letter: str) -> str:
    is_text = letter.isprintable() or letter in "\n\t" or category(letter) == "Zs"
    return letter if is_text else letter.encode("unicode_escape").decode()


WIDE = 200  # columns


def output() -> Terminal:
    """Return standard output; if it is a file or a pipe, tables are 200 columns wide."""
    console = Terminal()
    if console.is_terminal or "COLUMNS" in os.environ:
        return console
    return Terminal(width=WIDE)


def table_of(
    title: str, names: Sequence[str], figures: Sequence[str], rows: Iterable[Sequence[str]]
) -> Table:
    """Return a table: columns of names, flush left, then columns of figures, flush right."""
    table = Table(title=title)
    for name in names:
        table.add_column(name, overflow="fold")
    for name in figures:
        table.add_column(name, justify="right")
    for row in rows:
        table.add_row(*row)
    return table
