"""The command line `calot`; a new command is a new file and one line in COMMANDS."""

import io
import os
import re
import sys
import traceback
from collections.abc import Callable, Sequence
from contextlib import redirect_stderr
from importlib.metadata import version
from typing import Protocol

from tyro.extras import subcommand_cli_from_dict

from scenarios.commands.bench import Bench
from scenarios.commands.collect import Collect
from scenarios.commands.doctor import Doctor
from scenarios.commands.evaluate import Evaluate
from scenarios.commands.replay import Replay
from scenarios.commands.run import Run
from scenarios.commands.train import Train
from scenarios.commands.view import View
from scenarios.files.errors import (
    BAD_INPUT,
    ERROR,
    INTERRUPTED,
    BadInputError,
    outlives_its_readers,
    say,
)
from scenarios.files.outside_text import visible
from scenarios.workers.process import search_garbage_rarely, stop_code, stoppable
from tissue_sim.main_guard import MainGuardError

_RULE = "[─-]{3,}"


class Subcommand(Protocol):
    """A parsed command of the command line."""

    def execute(self) -> int:
        """Run the command; return the exit code."""
        ...


COMMANDS: dict[str, Callable[..., Subcommand]] = {
    "run": Run,
    "evaluate": Evaluate,
    "view": View,
    "replay": Replay,
    "train": Train,
    "collect": Collect,
    "bench": Bench,
    "doctor": Doctor,
}


@outlives_its_readers
def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code; bad input gives code 2 and a one-line message."""
    with stoppable(ends_program=argv is None):
        code = _executed(sys.argv[1:] if argv is None else list(argv))
    return stop_code() if code == INTERRUPTED else code


def _executed(words: list[str]) -> int:
    search_garbage_rarely()
    if words == ["--version"]:
        say(f"calot {version('calot')}", sys.stdout)
        return 0
    try:
        _require_text(words)
        _see_current_folder()
        return parse(words).execute()
    except (BadInputError, MainGuardError) as error:
        say(f"calot: {visible(str(error))}", sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        return INTERRUPTED
    except Exception:  # Python's own exit code for a traceback, 1, would report a failed episode
        traceback.print_exc()
        return ERROR


def _require_text(words: Sequence[str]) -> None:
    """Check that the words are valid text, because messages and files repeat them.

    Raises:
        BadInputError: A word has bytes that are not UTF-8, as names of files may have.
    """
    for word in words:
        try:
            word.encode()
        except UnicodeEncodeError:
            raise BadInputError(f"{os.fsencode(word)!r} is not UTF-8; name it otherwise") from None


def _see_current_folder() -> None:
    """Allow a policy MODULE:FACTORY in the user's current folder.

    Raises:
        BadInputError: The folder was removed.
    """
    try:
        here = os.getcwd()
    except FileNotFoundError:
        raise BadInputError("the current folder was removed; go to another one") from None
    if here not in sys.path:
        sys.path.append(here)


def parse(argv: Sequence[str] | None = None) -> Subcommand:
    """Return the command that the words name.

    Raises:
        BadInputError: The words name no command. The message is one line instead of tyro's box.
    """
    complaint = io.StringIO()
    try:
        with redirect_stderr(complaint):
            return subcommand_cli_from_dict(
                COMMANDS,
                prog="calot",
                description="A simulated robot surgeon for gallbladder removal (--version: which).",
                args=argv,
            )
    except SystemExit as stop:
        if stop.code != BAD_INPUT:
            raise
    except BrokenPipeError:  # nobody reads the help
        raise SystemExit(0) from None
    raise BadInputError(_one_line(complaint.getvalue()))


def _one_line(box: str) -> str:
    """Return the text in tyro's box, without its frame, its title and its pointers to the help.

    On a terminal with ASCII only, tyro draws no frame, and a rule below the title.
    """
    rows = [re.sub(r"^[│|]\s*|\s*[│|]$", "", row) for row in box.splitlines()]
    text = " ".join(row.strip() for row in rows if not row.startswith(("╭", "╰")))
    text = text if "╭" in box else re.split(_RULE, text, maxsplit=1)[-1]
    said, *_ = re.split(rf"{_RULE} (?:Argument helptext|For full helptext)", text)
    said = re.sub(r"(?: in calot [\w ]+ --help)+", "", said)
    return re.sub(rf"\s*{_RULE}\s*", "; ", said).strip(" ─-")


if __name__ == "__main__":
    sys.exit(main())
