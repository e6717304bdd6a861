"""Take one step of the tissue, stage by stage, on the CPU: one thread per environment.

One launch runs all stages, so Python does not run during the step, and threads that step other
environments overlap.
"""

from __future__ import annotations

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
