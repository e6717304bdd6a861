"""Time Calot's tissue and Newton's VBD solver in one run, and measure the error of each."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version
from time import perf_counter

import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from scenarios.bench.trials.newton_retraction import (
    RETRACTION_M,
    Solver,
    body_of,
    height_m,
    in_calot,
    in_newton,
)
from tissue_sim.mechanics.tissue import TissueConfig
from tissue_sim.patient.anatomy import anatomy_from_seed

STEPS = 60  # control steps: retract for one second, hold for another
NEWTON_SETTINGS = (  # substeps of a control step and iterations of Newton's own examples
    {"substeps": 20, "iterations": 10},  # softbody_hanging
    {"substeps": 20, "iterations": 5},  # softbody_franka
)
CONVERGED = TissueConfig(iterations=400, tolerance=1e-6, settled_j=0.0, damping_per_s=30.0)
CONVERGED_STEPS = 150


def bench_newton(*, seed: int) -> Table | str:
    """Time control steps of both under the same load; return a line if Newton is missing.

    The error is the largest distance of a vertex, at the end, from Calot's converged solution at
    rest. Newton's different material causes 0.5 mm of this error: 0.5 mm remain at rest with 100
    substeps of 10 iterations (seed 10004).
    """
    try:
        newton_version = version("newton")
    except PackageNotFoundError:
        return "Newton is not installed; to compare with it: .venv/bin/pip install -e '.[newton]'"
    body = body_of(anatomy_from_seed(seed))
    solvers = [
        in_calot(body, TissueConfig()),
        *(in_newton(body, **settings) for settings in NEWTON_SETTINGS),
    ]
    times_ms = race(solvers, STEPS)
    converged = in_calot(body, CONVERGED)
    race([converged], CONVERGED_STEPS)
    table = Table(
        title=f"Newton {newton_version} beside our tissue: {len(body.organ.tets)} tetrahedra, "
        f"seed {seed}, drawn up by {1e3 * RETRACTION_M:.0f} mm, {STEPS} control steps"
    )
    table.add_column("solver")
    for heading in ("median (ms)", "p95 (ms)", "ratio", "error (mm)"):
        table.add_column(heading, justify="right")
    for solver, laps_ms in zip(solvers, times_ms, strict=True):
        error_m = np.linalg.norm(solver.positions() - converged.positions(), axis=1).max()
        ratio = np.median(laps_ms) / np.median(times_ms[0])
        cells = (np.median(laps_ms), np.percentile(laps_ms, 95), ratio, 1e3 * error_m)
        table.add_row(solver.name, *(f"{value:.2f}" for value in cells))
    return table


def race(solvers: Sequence[Solver], steps: int) -> NDArray:
    """Return (solver, step) times of control steps, ms.

    The solvers alternate at every step, so that other load slows all of them alike.
    """
    times_s = np.zeros((len(solvers), steps))
    for n in range(steps):
        for k, solver in enumerate(solvers):
            start_s = perf_counter()
            solver.step(height_m(n), height_m(n + 1))
            times_s[k, n] = perf_counter() - start_s
    return 1e3 * times_s
