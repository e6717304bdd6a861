"""Options that need a renderer."""

from __future__ import annotations

from scenarios.files.errors import BadInputError


def require_renderer(option: str) -> None:
    """Check that there is a renderer for what `option` asks for.

    Raises:
        BadInputError: there is none.
    """
    from tissue_sim.rendering.renderer_probe import renderer_available

    if not renderer_available():
        raise BadInputError(f"{option} needs a renderer and there is none; see `calot doctor`")
