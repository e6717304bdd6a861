"""Options that need a renderer."""

from __future__ import annotations

from collections.abc import Sequence

from scenarios.files.errors import BadInputError
from tissue_sim.sensing.pictures.camera_names import CAMERA_NAMES


def require_cameras(cameras: Sequence[str]) -> None:
    """Check that there are cameras of these names, and a renderer if there are any.

    Raises:
        BadInputError: there are not.
    """
    if unknown := [name for name in cameras if name not in CAMERA_NAMES]:
        raise BadInputError(
            f"--cameras: there is no {', '.join(unknown)}; allowed: {', '.join(CAMERA_NAMES)}"
        )
    if cameras:
        require_renderer("--cameras")


def require_renderer(option: str) -> None:
    """Check that there is a renderer for what `option` asks for.

    Raises:
        BadInputError: there is none.
    """
    from tissue_sim.rendering.renderer_probe import renderer_available

    if not renderer_available():
        raise BadInputError(f"{option} needs a renderer and there is none; see `calot doctor`")
