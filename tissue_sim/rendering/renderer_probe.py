"""Whether SAPIEN can render here."""

import subprocess
import sys
from functools import cache

_ATTEMPT = "import sapien; sapien.render.RenderSystem(sapien.Device('cpu'))"


@cache
def renderer_available() -> bool:
    """Tries to make a render system in a process of its own, which takes about 0.7 s.

    A failed Vulkan set-up can poison the process it happens in, or crash it at exit.
    """
    return subprocess.run([sys.executable, "-c", _ATTEMPT], capture_output=True).returncode == 0


if __name__ == "__main__":
    sys.exit(0 if renderer_available() else 1)
