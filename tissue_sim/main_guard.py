"""Require a main guard in scripts that start processes, because each process imports the script."""

import ast
import sys
from pathlib import Path
from types import FrameType


class MainGuardError(RuntimeError):
    """A script would start processes during its own import."""


def require_main_guard() -> None:
    """Check that the running program is not a script without a guard, before processes start.

    Raises:
        MainGuardError: the program is a script without a guard; the message names the line.
    """
    frame = _line_of_script()
    if frame is not None and not _is_guarded(Path(frame.f_code.co_filename), frame.f_lineno):
        raise MainGuardError(
            f"{frame.f_code.co_filename}:{frame.f_lineno}: each process that this line starts would"
            ' import the script and start more: put the line below `if __name__ == "__main__":`'
        )


def _line_of_script() -> FrameType | None:
    """Return the frame of the calling script; None if new processes import no script."""
    own, frame = vars(sys.modules["__main__"]), sys._getframe()
    while frame is not None:
        if frame.f_globals is own and frame.f_code.co_name == "<module>":
            return frame if Path(frame.f_code.co_filename).is_file() else None
        frame = frame.f_back
    return None


def _is_guarded(script: Path, line: int) -> bool:
    return any(
        isinstance(node, ast.If)
        and "__name__" in ast.unparse(node.test)
        and node.lineno <= line <= (node.end_lineno or line)
        for node in ast.walk(ast.parse(script.read_bytes()))
    )
