"""Can SAPIEN render on this machine, and with what?"""

import subprocess
import sys
from functools import cache

from tissue_sim.rendering import renderer

KINDS = ("gpu", "system", "private")


@cache
def renderer_kind() -> str | None:
    """Return one of `KINDS` if a render system can be made, by a trial in a new process (0.7 s).

    A failed Vulkan set-up can break its process, or crash it at exit.
    """
    attempt = [sys.executable, "-P", renderer.__file__]
    tried = subprocess.run(attempt, capture_output=True, text=True)
    last = (tried.stdout.splitlines() or [""])[-1]
    return last if tried.returncode == 0 and last in KINDS else None


def renderer_available() -> bool:
    """Return whether pictures can be taken here, and prepare this process to take them."""
    kind = renderer_kind()
    if kind == "private":
        renderer.use_private_renderer()
    return kind is not None


if __name__ == "__main__":
    sys.exit(0 if renderer_available() else 1)
