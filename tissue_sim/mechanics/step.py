"""Take one step of the tissue, stage by stage, on the CPU: one thread per environment.

One launch runs all stages, so Python does not run during the step, and threads that step other
environments overlap.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import warp as wp

from tissue_sim.mechanics.arrays import TissueArrays, ToolShapes
from tissue_sim.mechanics.assembly import add_elements
from tissue_sim.mechanics.bar_contact import add_bar_contact, react_to_bars
from tissue_sim.mechanics.gallbladder_contact import add_sac_contact
from tissue_sim.mechanics.implicit import StepParameters, begin_step, solve_step
from tissue_sim.mechanics.springs import add_springs, break_springs
from tissue_sim.mechanics.strands import add_strands, break_strands, react_to_strands
from tissue_sim.mechanics.touch import add_surface_contact, react_on_tools
from tissue_sim.mechanics.tube_contact import add_tube_contact
from tissue_sim.mechanics.untangle import untangle

wp.set_module_options({"enable_backward": False})


@dataclass(frozen=True, kw_only=True)
class TissueConfig:
    """Step size, damping, gravity and solver settings of the tissue.

    Attributes:
        iterations: Largest number of conjugate-gradient iterations in each step; assumed.
        tolerance: Bound on the preconditioned residual, relative to its start; assumed.
        settled_j: Preconditioned residual, as an energy, that always ends the iteration.
    """

    step_s: float = (
        1.0 / 60.0
    )  # two steps per control step: a single step leaves tangles after a crush
    damping_per_s: float = 5.0  # mass-proportional, assumed
    viscosity_s: float = 1.0 / 30.0  # Kelvin-Voigt; loss tangent 0.2 at 1 Hz, assumed
    gravity_m_s2: tuple[float, float, float] = (0.0, 0.0, -9.81)
    iterations: int = 60
    tolerance: float = 1.0e-2
    settled_j: float = 1.0e-10  # about a micrometre at the tubes' stiffness


def step_parameters(config: TissueConfig) -> Any:
    """Convert the configuration to the kernels' structure."""
    c: Any = StepParameters()
    c.step_s = config.step_s
    c.viscosity = config.viscosity_s / config.step_s
    c.damping_per_s = config.damping_per_s
    c.gravity = wp.vec3(*config.gravity_m_s2)
    c.iterations = config.iterations
    c.tolerance = config.tolerance
    c.settled_j = config.settled_j
    return c


STAGES = (
    "predict",
    "untangle",
    "elements",
    "springs",
    "tube contact",
    "tool and bed contact",
    "bar contact",
    "solve",
    "breakage",
    "reactions",
)


@wp.kernel
def take_stages(t: TissueArrays, s: ToolShapes, c: StepParameters, first: int, end: int):
    """Run the stages `first` to `end` - 1, by their places in `STAGES`."""
    b = wp.tid()
    for stage in range(first, end):
        if stage == 0:
            begin_step(t, b, c.step_s)
        if stage == 1:
            untangle(t, b)
        if stage == 2:
            add_elements(t, b, c.viscosity)
        if stage == 3:
            add_strands(t, s, b)
            add_springs(t, b)
        if stage == 4:
            add_tube_contact(t, b)
            add_sac_contact(t, b)
        if stage == 5:
            add_surface_contact(t, s, b)
        if stage == 6:
            add_bar_contact(t, s, b)
        if stage == 7:
            solve_step(t, b, c)
        if stage == 8:
            break_springs(t, b)
            break_strands(t, s, b)
        if stage == 9:
            react_on_tools(t, s, b)
            react_to_bars(t, s, b)
            react_to_strands(t, s, b)
