"""Settled tubes of patients, and clips and cuts made in them as the tools would make them."""

import numpy as np

from tests.tissue_sim.kinds import POLYMER
from tests.tissue_sim.verification.bodies import astride
from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.patient.organ import build_organ
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.patient.tubes import Tubes
from tissue_sim.surgery.clip import Clip, grip_n, holding_forces_n, latch
from tissue_sim.surgery.cut import BLADE_LENGTH_M, Cut, sever
from tissue_sim.tools.clips import ClipKind

SETTLE_STEPS, HALF_SECOND = 45, 30
STRENGTHS = ("tie_strength", "anchor_strength")  # no part of a state; some tests change them
_SETTLED: dict[int, tuple[Tubes, dict[str, np.ndarray]]] = {}


def settled(seed: int) -> Tubes:
    """Return a patient's settled tubes; computed once per seed and restored each time."""
    if seed not in _SETTLED:
        patient = textbook_from_seed(seed)
        organ = build_organ(patient)
        tissue = Tissue([organ], stiffness_scale=[patient.stiffness_scale])
        for _ in range(SETTLE_STEPS):
            tissue.step()
        strengths = {name: tissue.host(name).copy() for name in STRENGTHS}
        _SETTLED[seed] = Tubes(tissue, organ), tissue.state() | strengths
    tubes, state = _SETTLED[seed]
    tubes.tissue.restore(state)
    for name in STRENGTHS:
        tubes.tissue.host(name)[:] = state[name]
    return Tubes(tubes.tissue, tubes.organ)


def run(tubes: Tubes, steps: int = HALF_SECOND) -> None:
    for _ in range(steps):
        tubes.tissue.step()


def clip_at(
    tubes: Tubes, tube: str, share: float = 0.5, kind: ClipKind = POLYMER, **how: float
) -> Clip:
    """Latch a clip at a share of the tube's length."""
    station = share * tubes.length_m[tube]
    T = astride(tubes, tube, station, **({"beyond_m": kind.length_m / 2} | how))
    return latch(tubes, T, kind, number=1, time_s=0.0)


def cut_at(tubes: Tubes, tube: str, station_m: float, **how: float) -> tuple[Cut, ...]:
    """Close the blades across the tube at a station."""
    T = astride(tubes, tube, station_m, **({"beyond_m": BLADE_LENGTH_M / 2} | how))
    return sever(tubes, T, time_s=0.0)


def retention_n(tubes: Tubes, clip: Clip) -> float:
    """Return the largest pull along its tube that a clip holds now, N."""
    return holding_forces_n(tubes, clip, grip_n(tubes, clip))[0]


def lumen_shares(tubes: Tubes, tube: str) -> np.ndarray:
    """Return the (n_ring,) area of the lumen over its area at rest, below any cut."""
    rings = range(len(tubes.below[tube]))
    return np.array([tubes.lumen_fraction_at(tube, ring, 0.0) for ring in rings])
