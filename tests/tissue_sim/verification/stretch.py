"""Compare a bar pulled at both ends, with or without fibres, with its energy's stationary point."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import root

from tests.tissue_sim.verification.bodies import EPS, SETTLED_M, box, face_share, overdamped, settle
from tissue_sim.frames import Array
from tissue_sim.patient.material import Material

SIZE_M = (0.02, 0.008, 0.008)
YOUNG_PA = 50e3


@dataclass(frozen=True, kw_only=True)
class Stretch:
    """Principal stretches of a bar under tractions.

    Attributes:
        poisson: Poisson's ratio.
        stress_over_young: (n,), traction per rest area over Young's modulus.
        measured: (n, 3), stretches along and twice across.
        expected: (n, 2), stretches along and across.
        uneven: (n,), largest distance of a vertex from the uniform stretch, over the length.
        tolerance: Bound for the remaining motion, and the effect of a force's noise on a strain.
    """

    poisson: float
    stress_over_young: Array
    measured: Array
    expected: Array
    uneven: Array
    tolerance: float


def stretch(
    poisson: float, stress_over_young: Sequence[float], collagen_over_young: float = 0.0
) -> Stretch:
    """Pull a bar evenly: F is then uniform, which linear elements represent exactly.

    The bar is only pulled, because a free body under pressure turns over. Its fibres lie along the
    bar.
    """
    material = Material(young_pa=YOUNG_PA, poisson=poisson)
    collagen_pa = collagen_over_young * YOUNG_PA
    pulled = [_pull(material, collagen_pa, share * YOUNG_PA) for share in stress_over_young]
    return Stretch(
        poisson=poisson,
        stress_over_young=np.array(stress_over_young),
        measured=np.array([s for s, _ in pulled]),
        expected=np.array(
            [stretches(share * YOUNG_PA, material, collagen_pa) for share in stress_over_young]
        ),
        uneven=np.array([uneven for _, uneven in pulled]),
        # the noise of a force is eps times its largest stress
        tolerance=100 * SETTLED_M / SIZE_M[0] + 100 * EPS / (1 - 2 * poisson),
    )


def stretches(
    stress_pa: float, material: Material, collagen_pa: float = 0.0
) -> tuple[float, float]:
    """Return the stretches along and across a pulled bar.

    The stretches minimise mu sum (s_i - 1)^2 + lambda / 2 (J - 1)^2 + c / 4 (s_1 - 1)^4 - P s_1.
    """
    mu, lam = material.lame

    def fibres(s: float) -> float:
        return collagen_pa * (s - 1) ** 3

    def unbalanced(s: Sequence[float]) -> list[float]:
        dJ = s[0] * s[1] ** 2 - 1
        return [
            (2 * mu * (s[0] - 1) + lam * dJ * s[1] ** 2 + fibres(s[0]) - stress_pa) / mu,
            (2 * mu * (s[1] - 1) + lam * dJ * s[0] * s[1]) / mu,
        ]

    guess = 1 + stress_pa / material.young_pa
    along, across = root(unbalanced, [guess, guess**-0.5], tol=1e-12).x
    return along, across


def _pull(material: Material, collagen_pa: float, stress_pa: float) -> tuple[Array, float]:
    """Return the settled bar's principal stretches (3,), and their unevenness."""
    rest, tets = box(SIZE_M, (5, 2, 2))
    load = np.zeros_like(rest)
    ends = face_share(rest, tets, 0, SIZE_M[0]) - face_share(rest, tets, 0, 0.0)
    load[:, 0] = stress_pa * ends
    tissue = overdamped(rest, tets, material)
    tissue.host("fibre")[:], tissue.host("collagen")[:] = (1.0, 0.0, 0.0), collagen_pa
    x = settle(tissue, load)
    x, rest = x - x.mean(axis=0), rest - rest.mean(axis=0)
    F = np.linalg.lstsq(rest, x, rcond=None)[0].T
    return np.linalg.svd(F)[1], float(np.abs(x - rest @ F.T).max() / SIZE_M[0])
