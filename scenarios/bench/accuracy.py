"""Measure the error of the tissue against its converged static solution after a retraction."""

from __future__ import annotations

from rich.table import Table

from scenarios.files.errors import refusing
from scenarios.files.outside_text import table_of
from tissue_sim.patient.anatomy import Anatomy, anatomy_from_seed
from tissue_sim.patient.organ import build_organ
from tissue_sim.verification.retraction import MAX_ERROR_M, Retraction, retraction
from tissue_sim.world import WorldConfig

REFINEMENTS = (1, 2)
HALVINGS = 5  # how often the held time is halved for further rows of the table
MM = 1e-3


def bench_accuracy(*, seed: int, steps: int) -> tuple[Table, str]:
    """Retract the infundibulum by 20 mm in 1 s and hold it for `steps` control steps.

    Raises:
        BadInputError: There is no static solution to compare with.
    """
    anatomy, config = anatomy_from_seed(seed), WorldConfig()
    held_steps = sorted({0, *(steps // 2**k for k in range(HALVINGS + 1))})
    held_s = [n * config.control_step_s for n in held_steps]
    with refusing(ArithmeticError, before=f"--seed {seed}: ", after="; take another seed"):
        results = [_measured(anatomy, config, refinement, held_s) for refinement in REFINEMENTS]
    return _table(results, seed), _verdict(results)


def _measured(
    anatomy: Anatomy, config: WorldConfig, refinement: int, held_s: list[float]
) -> Retraction:
    organ = build_organ(anatomy, refinement=refinement)
    return retraction(organ, anatomy.stiffness_scale, config.tissue, held_s=held_s)


_HEADINGS = (
    "tetrahedra",
    "retracted (mm)",
    "held (s)",
    "largest error (mm)",
    "RMS (mm)",
    "largest, solved tightly (mm)",
)


def _table(results: list[Retraction], seed: int) -> Table:
    table = table_of(f"against the converged static solution, seed {seed}", (), _HEADINGS, ())
    for r in results:
        for row in zip(r.held_s, r.largest_m, r.rms_m, r.lag_m, strict=True):
            held_s, *errors_m = (float(x) for x in row)
            errors = (f"{error_m / MM:.5f}" for error_m in errors_m)
            table.add_row(f"{r.tets}", f"{r.shift_m / MM:.0f}", f"{held_s:.2f}", *errors)
        table.add_section()
    return table


def _verdict(results: list[Retraction]) -> str:
    worst_m = max(float(r.largest_m[-1]) for r in results)
    broken = ", ".join(f"{r.broken}" for r in results)
    return (
        f"at rest: {worst_m / MM:.5f} mm at most, allowed {MAX_ERROR_M / MM:.1f} mm;"
        f" springs broken: {broken}; liver bed and attachments included"
    )
