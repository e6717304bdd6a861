"""Which options of an environment and of its reset are allowed? Errors name the invalid options."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import fields
from typing import Any

from tissue_sim.control_modes import N_NUMBERS
from tissue_sim.patient.anatomy import Anatomy, Artery
from tissue_sim.rendering.renderer import renderer_available
from tissue_sim.state_check import require_names, require_type
from tissue_sim.world import WorldConfig

CPU_BACKENDS = ("auto", "cpu", "physx_cpu")
BLIND_MODES = ("state", "state_dict", "none")
RESET_OPTIONS = (
    "anatomy",
    "reconfigure",
    "env_idx",
    "reset_to_env_states",
)  # the last three are ManiSkill's
DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY")


def require_backend(num_envs: int, sim_backend: str) -> None:
    """Check that the request is for one environment on the CPU."""
    if num_envs != 1:
        raise ValueError(f"num_envs = {num_envs}: only 1; use gymnasium's vector environments")
    if sim_backend not in CPU_BACKENDS:
        raise ValueError(f"sim_backend = {sim_backend!r}: choose from {CPU_BACKENDS}")


def require_robot(robot_uids: str, control_mode: str) -> None:
    """Check that the request names no other robot and no unknown control mode."""
    if robot_uids != "none":
        raise ValueError(f"robot_uids = {robot_uids!r}: its two arms are part of it; leave it out")
    if control_mode not in N_NUMBERS:
        raise ValueError(f"control_mode = {control_mode!r}: choose from {tuple(N_NUMBERS)}")


def require_renderer(render_backend: str) -> None:
    """Check that pictures can be drawn if the backend draws."""
    if render_backend != "none" and not renderer_available():
        raise ValueError(
            f"render_backend = {render_backend!r}: there is no renderer here; use 'none' with "
            f"obs_mode in {BLIND_MODES} (see `calot doctor`)"
        )


def render_modes() -> list[str]:
    """Return the render modes that work on this machine."""
    if not renderer_available():
        return []
    window = ["human"] if any(os.environ.get(name) for name in DISPLAYS) else []
    return ["rgb_array", "sensors", "all", *window]


def require_reset_options(options: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return the options of a reset; an anatomy in the form of its fields becomes an `Anatomy`.

    Raises:
        ValueError: an option is unknown, or the anatomy is invalid.
    """
    if not isinstance(options, Mapping | None):
        raise ValueError(f"options: it is a {type(options).__name__}; expected: dict")
    given = dict(options or {})
    unknown = sorted(str(name) for name in given if name not in RESET_OPTIONS)
    if unknown:
        raise ValueError(f"options: unknown: {', '.join(unknown)}; choose from {RESET_OPTIONS}")
    states = given.get("reset_to_env_states", {"env_states": {}})
    if not isinstance(states, Mapping) or states.get("env_states") is None:
        raise ValueError(
            "options['reset_to_env_states']: it must be {'env_states': a state of this environment}"
        )
    if given.get("anatomy") is not None:
        given["anatomy"] = _anatomy(given["anatomy"])
    return given


def _anatomy(given: Any) -> Anatomy:
    """Return an `Anatomy` from an `Anatomy` or from its fields, as trajectories record them."""
    if isinstance(given, Mapping):
        require_names(set(given), {f.name for f in fields(Anatomy)}, "options['anatomy']")
        values: dict[str, Any] = {
            k: tuple(v) if isinstance(v, list) else v for k, v in given.items()
        }
        second = values["second_artery"]
        if isinstance(second, Mapping):
            require_names(set(second), {f.name for f in fields(Artery)}, "second_artery")
            values["second_artery"] = Artery(**second)
        return Anatomy(**values)
    require_type(given, Anatomy, "options['anatomy']")
    return given


def first_seed(seed: int | Iterable[int] | None) -> int | None:
    """Return the seed of the only environment; ManiSkill wraps it in a list."""
    if not isinstance(seed, Iterable):
        return seed
    seeds = list(seed)
    if len(seeds) != 1:
        raise ValueError(f"seed = {seed!r} must be a number, or a list of one")
    return int(seeds[0])


def world_config(given: Mapping[str, Any]) -> WorldConfig:
    """Convert ManiSkill's frequencies to periods.

    Raises:
        ValueError: a frequency does not divide the next one.
    """
    own = WorldConfig()
    control_hz = given.get("control_freq", round(1.0 / own.control_step_s))
    sim_hz = given.get("sim_freq", round(1.0 / own.physics_step_s))
    tissue_hz = round(1.0 / own.tissue.step_s)
    if min(control_hz, sim_hz) <= 0 or sim_hz % tissue_hz or tissue_hz % control_hz:
        raise ValueError(
            f"control_freq = {control_hz}, sim_freq = {sim_hz}: control_freq must divide "
            f"{tissue_hz} Hz, the tissue's rate, and that must divide sim_freq"
        )
    return WorldConfig(control_step_s=1.0 / control_hz, physics_step_s=1.0 / sim_hz)
