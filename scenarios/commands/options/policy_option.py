"""`--planner` and `--controller`: checked before anything starts, and named on the screen."""

from pathlib import Path

from scenarios.catalogue import CONTROLLERS, policy_named, sense_named
from scenarios.commands.options.checkpoint_option import (
    require_checkpoint,
    require_perception_checkpoint,
    require_planner_checkpoint,
)
from scenarios.commands.options.endpoint_option import require_endpoint
from scenarios.commands.options.renderer_option import require_renderer
from scenarios.files.errors import BadInputError
from scenarios.files.outside_text import Terminal


def require_policies(
    planner: str,
    controller: str,
    checkpoint: Path | None,
    planner_checkpoint: Path | None,
    cameras: tuple[str, ...] = (),
) -> None:
    """Check that both policies can be made.

    Raises:
        BadInputError: a factory cannot be imported, a checkpoint does not fit, the endpoint that
            the planner asks or a camera that the controller needs is not named, or the controller
            looks at no pictures.
    """
    for option, name in (("--planner", planner), ("--controller", controller)):
        if ":" in name:
            _require_factory(option, name)
    _require_pictured(controller, cameras)
    require_checkpoint(controller, checkpoint, cameras)
    require_planner_checkpoint(planner, planner_checkpoint)
    if policy_named(planner).endpoint:
        require_endpoint()


def _require_pictured(controller: str, cameras: tuple[str, ...]) -> None:
    if cameras and ":" not in controller and not policy_named(controller).pictures:
        able = (name for name, policy in CONTROLLERS.items() if policy.pictures)
        raise BadInputError(
            f"--cameras: controller {controller!r} looks at no pictures; these do:"
            f" {', '.join(able)}, MODULE:FACTORY"
        )


def require_perception(sense: str, checkpoint: Path | None) -> None:
    """Check that a sense can be made: its factory, its checkpoint, and a renderer if it needs one.

    Raises:
        BadInputError: there is no factory, the checkpoint does not fit or is not wanted, or there
            is no renderer.
    """
    if ":" in sense:
        _require_factory("--sense", sense)
    else:
        require_perception_checkpoint(sense, checkpoint)
    if sense_named(sense).renders:
        require_renderer(f"--sense {sense}")


def say_who_acts(
    planner: str, controller: str, sense: str, person: str | None = None, arm: str | None = None
) -> None:
    """Print who plans, moves and corrects, how everybody who acts observes, and in which arm."""
    line = "" if arm is None else f"arm {arm}: "
    line += f"planner: {_described(planner)}; controller: {_described(controller)}"
    line += "" if person is None else f"; person: {person} (scripted: it sees the truth)"
    Terminal(stderr=True).print(
        f"{line}\nsense: {sense}: {sense_named(sense).description}",
        highlight=False,
        markup=False,
        soft_wrap=True,
    )


def _described(name: str) -> str:
    return f"{name} (privileged: it reads the hidden state)" if _is_privileged(name) else name


def _is_privileged(name: str) -> bool:
    """Return whether the policy reads the hidden state."""
    if ":" not in name:
        return policy_named(name).privileged
    from scenarios.loop.policies import reads_hidden_state

    return reads_hidden_state(name)


def _require_factory(option: str, name: str) -> None:
    from scenarios.loop.policies import require_factory

    try:
        require_factory(name)
    except ValueError as error:
        raise BadInputError(f"{option} {error}") from None
