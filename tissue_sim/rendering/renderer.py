"""Which renderer draws here: a GPU, the system's software renderer, or the private renderer?

`make cameras` puts Mesa's software renderer in a folder of the Python environment, for machines
without another renderer. Each process that draws loads this renderer. Vulkan's choice of driver is
set in the environment of its child processes. The renderer needs neither root nor
`LD_LIBRARY_PATH`.

A probe runs this file alone in a new process, so it imports only the standard library at its top.
"""

import os
import subprocess
import sys
from ctypes import CDLL
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import sapien

PRIVATE_FOLDER = Path(sys.prefix) / "renderer"
DRIVER = "driver.json"  # path of the driver for Vulkan's loader
LIBRARIES = "libraries.txt"  # one path a line, relative to the folder: dependencies come first
DRIVERS_VARIABLE = "VK_DRIVER_FILES"
OTHER_CHOICES = ("VK_ICD_FILENAMES", "VK_ADD_DRIVER_FILES")
KINDS = ("gpu", "system", "private")


def use_private_renderer(folder: Path = PRIVATE_FOLDER) -> bool:
    """Use the private renderer if it exists and the user has chosen no other driver.

    Call the function before the first Vulkan instance of the process; a second call changes
    nothing. The driver finds its libraries because they are loaded already.

    Returns:
        Whether the private renderer is the one that Vulkan finds.

    Raises:
        OSError: a file of the renderer is missing or broken. Call `renderer_kind` before, which
            tries in another process.
    """
    if _is_another_chosen(folder) or not (folder / DRIVER).exists():
        return False
    for library in (folder / LIBRARIES).read_text().splitlines():
        CDLL(str(folder / library))
    os.environ[DRIVERS_VARIABLE] = str(folder / DRIVER)
    return True


def _is_another_chosen(folder: Path) -> bool:
    """Return whether the environment names a driver other than the private one."""
    chosen = os.environ.get(DRIVERS_VARIABLE)
    if chosen is not None:
        return chosen != str(folder / DRIVER)
    return any(name in os.environ for name in OTHER_CHOICES)


def render_system() -> "sapien.render.RenderSystem":
    """Make a render system, on a GPU if one can draw.

    Raises:
        RuntimeError: there is no renderer here.
    """
    try:
        private = use_private_renderer()
    except OSError as error:
        raise RuntimeError(f"renderer: the private one is broken: {error}") from error
    import sapien

    return sapien.render.RenderSystem(sapien.Device("cpu") if private else _fastest_device())


def _fastest_device() -> "sapien.Device":
    import sapien

    try:
        return sapien.Device("cuda")
    except RuntimeError:
        return sapien.Device("cpu")


def _kind() -> str:
    """Make a render system and return the renderer's kind."""
    private = use_private_renderer()
    if render_system().device.is_cuda():
        return "gpu"
    return "private" if private else "system"


@cache
def renderer_kind() -> str | None:
    """Return one of `KINDS` if a render system can be made, by a trial in a new process (0.7 s).

    A failed Vulkan set-up can break its process, or crash it at exit.
    """
    attempt = [sys.executable, "-P", __file__]
    tried = subprocess.run(attempt, capture_output=True, text=True)
    last = (tried.stdout.splitlines() or [""])[-1]
    return last if tried.returncode == 0 and last in KINDS else None


def renderer_available() -> bool:
    """Return whether pictures can be taken here, and prepare this process to take them."""
    kind = renderer_kind()
    if kind == "private":
        use_private_renderer()
    return kind is not None


if __name__ == "__main__":
    print(_kind())
