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
from scenarios.files.errors import BadInputError
from scenarios.files.exit_codes import BAD_INPUT, ERROR, INTERRUPTED
from scenarios.files.outside_text import visible
from scenarios.workers.garbage import search_garbage_rarely

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


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; return its exit code; bad input gives 2 and a message in one line."""
    if os.getcwd() not in sys.path:  # a policy MODULE:FACTORY may lie in the user's folder
        sys.path.append(os.getcwd())
    search_garbage_rarely()
    if (sys.argv[1:] if argv is None else list(argv)) == ["--version"]:
        print(f"calot {version('calot')}")
        return 0
    try:
        return parse(argv).execute()
    except BadInputError as error:
        print(f"calot: {visible(str(error))}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        return INTERRUPTED
    except Exception:  # Python's own exit code for it, 1, would say that an episode failed
        traceback.print_exc()
        return ERROR


def parse(argv: Sequence[str] | None = None) -> Subcommand:
    """Return the command that the words name.

    Raises:
        BadInputError: the words name no command; in one line instead of tyro's box.
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
    raise BadInputError(_one_line(complaint.getvalue()))


def _one_line(box: str) -> str:
    """Return the text in tyro's box, without its frame, its title and its pointers to the help.

    Where the terminal has ASCII only, there is no frame, and a rule below the title.
    """
    rows = [re.sub(r"^[│|]\s*|\s*[│|]$", "", row) for row in box.splitlines()]
    text = " ".join(row.strip() for row in rows if not row.startswith(("╭", "╰")))
    text = text if "╭" in box else re.split(_RULE, text, maxsplit=1)[-1]
    said, *_ = re.split(rf"{_RULE} (?:Argument helptext|For full helptext)", text)
    said = re.sub(r"(?: in calot [\w ]+ --help)+", "", said)
    return re.sub(rf"\s*{_RULE}\s*", "; ", said).strip(" ─-")


if __name__ == "__main__":
    sys.exit(main())
