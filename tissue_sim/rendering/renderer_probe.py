"""Can SAPIEN render on this machine?"""

import subprocess
import sys
from functools import cache

_ATTEMPT = "import sapien; sapien.render.RenderSystem(sapien.Device('cpu'))"


@cache
def renderer_available() -> bool:
    """Return whether a render system can be made, by trying in a new process (about 0.7 s).

    A failed Vulkan set-up can break the process in which it happens, or crash it at exit.
    """
    return subprocess.run([sys.executable, "-c", _ATTEMPT], capture_output=True).returncode == 0


if __name__ == "__main__":
    sys.exit(0 if renderer_available() else 1)
