"""One storm on one patient, and the laws that the tissue must obey during and after it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice, pairwise

import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from scenarios.bench.trials.run_trials import Trial
from scenarios.bench.trials.storm import OPEN_RAD, storm
from scenarios.files.outside_text import table_of
from tissue_sim.frames import Array
from tissue_sim.mechanics.topology import components
from tissue_sim.patient.anatomy import anatomy_from_seed
from tissue_sim.patient.material import DENSITY_KG_M3, MATERIALS
from tissue_sim.patient.organ import REGIONS
from tissue_sim.tools.arms import HOME_JOINTS, RIGHT_ARM, JointCommand
from tissue_sim.tools.psm import forward_kinematics
from tissue_sim.world import World

STORM_S = 3.0
RETREAT_S = 1.0  # the tools open and go home
REST_S = 2.0
VOLUME_WITHIN = 0.10  # allowed change of volume, relative to rest, assumed
ENERGY_NOISE_J = 1.0e-5  # rounding, and small motions of tissue in a clip; assumed
GRAVITY_M_S2 = 9.81
LUMENS = [k for k, name in enumerate(REGIONS) if "lumen" in name]  # hollow: may be emptied


@dataclass(frozen=True, kw_only=True)
class StormTrial(Trial):
    """Result of one storm.

    Attributes:
        laws: The laws that the storm broke.
        commanded_speed_m_s: Largest of either tip, from the joint targets.
        tip_speed_m_s: 99th percentile of both tips; arms that cross spring apart.
        tissue_speed_m_s: Largest of any vertex.
        force_n: Largest on a tool.
        energy_j: Largest elastic and kinetic energy of the tissue, above that at rest.
        volume: (2,) smallest and largest during the storm, relative to rest.
        inverted: Largest number of inverted elements during the storm.
        touched, clipped, cut: Whether this happened to the tissue.
        torn: Whether a tube tore, or the sac's wall tore without a blade.
        detached: Whether sac or tubes detached from their attachments.
        caught: Whether a tool still holds tissue after the retreat, so that the tissue is not at
            rest.
    """

    laws: tuple[str, ...] = ()
    commanded_speed_m_s: float = np.nan
    tip_speed_m_s: float = np.nan
    tissue_speed_m_s: float = np.nan
    force_n: float = np.nan
    energy_j: float = np.nan
    volume: tuple[float, float] = (np.nan, np.nan)
    inverted: int = 0
    touched: bool = False
    clipped: bool = False
    cut: bool = False
    torn: bool = False
    detached: bool = False
    caught: bool = False

    @property
    def broken(self) -> tuple[str, ...]:
        """Return the laws that the storm broke, or the exception that ended it; empty for none."""
        return (self.error,) if self.error else self.laws


@dataclass(frozen=True, kw_only=True)
class StormSample:
    """Measurements after a control step."""

    finite: bool
    tips_m: Array  # (2, 3)
    commanded_m: Array  # (2, 3) where the joint targets put the tips
    tool: str  # on the right arm
    tissue_speed_m_s: float
    force_n: float
    energy_j: float
    height_energy_j: float
    volume: float
    inverted: int
    touched: bool


def run_trial(seed: int) -> StormTrial:
    """Run a storm on a patient; the seed gives both."""
    world = World()
    world.reset(anatomy_from_seed(seed))
    return trial_on(world, seed)


def trial_on(world: World, seed: int) -> StormTrial:
    """Run the seed's storm on a patient as it lies there, release, rest, and judge."""
    springs = _springs(world)
    first = _measure(world)
    stormy = list(_follow(world, islice(storm(world, seed), _steps(world, STORM_S))))
    list(_follow(world, _retreat(world)))
    detached = _springs(world) < springs
    still = [_measure(world), *_follow(world, [_home()] * _steps(world, REST_S))]
    injuries = {injury.event for injury in world.record.injuries}
    return StormTrial(
        seed=seed,
        laws=tuple(_broken_laws(world, stormy, still)),
        commanded_speed_m_s=float(_speeds(world, stormy, "commanded_m").max()),
        tip_speed_m_s=float(np.percentile(_speeds(world, stormy, "tips_m"), 99)),
        tissue_speed_m_s=max(m.tissue_speed_m_s for m in stormy),
        force_n=max(m.force_n for m in stormy),
        energy_j=max(m.energy_j for m in stormy) - first.energy_j,
        volume=(min(m.volume for m in stormy), max(m.volume for m in stormy)),
        inverted=max(m.inverted for m in stormy),
        touched=any(m.touched for m in stormy),
        clipped=any(clip.crossings for clip in world.record.clips),
        cut=bool(world.record.cuts) or "cut on gallbladder" in injuries,
        torn=bool(world.record.tears) or "tear of gallbladder" in injuries,
        detached=detached,
        caught=still[-1].touched,
    )


def intact(world: World) -> NDArray[np.bool_]:
    """Return (n_tet,) elements that are alive, connected to the body, and not under a clip."""
    tissue = world.tissue
    tets, n = tissue.tets(), tissue.n_vertex()
    ties = tissue.host("tie_corner")[0][tissue.host("tie_stiffness")[0] > 0.0]
    label = components(n, np.concatenate([tets, ties[:, :4]]))
    anchors = tissue.host("anchor")[0][tissue.host("anchor_stiffness")[0] > 0.0]
    held = label[np.concatenate([np.flatnonzero(tissue.host("fixed")[0, :n]), anchors])]
    alive = tissue.host("tet_alive")[0, : len(tets)] != 0
    clipped = (tissue.host("covered")[0][tets] != 0).any(axis=1)
    return alive & np.isin(label[tets[:, 0]], held) & ~clipped


def _broken_laws(
    world: World, stormy: list[StormSample], still: list[StormSample]
) -> Iterator[str]:
    if not all(m.finite for m in (*stormy, *still)):
        yield "not finite"
    fastest = max(m.tissue_speed_m_s for m in (*stormy, *still))
    if fastest > wave_speed_m_s(world):
        yield f"tissue at {fastest:.0f} m/s"
    gained_j = still[-1].energy_j + still[-1].height_energy_j
    gained_j -= still[0].energy_j + still[0].height_energy_j
    if gained_j > ENERGY_NOISE_J and not still[-1].touched:
        yield f"gained {1e3 * gained_j:.2f} mJ at rest"
    yield from _spoiled(world)


def _spoiled(world: World) -> Iterator[str]:
    """Yield the faults of intact tissue after its rest."""
    tissue, region, whole = world.tissue, world.organ.region, intact(world)
    now, rest = tissue.volumes(), tissue.host("volume")[0, : len(region)]
    for k, name in enumerate(REGIONS):
        chosen = whole & (region == k)
        if k in LUMENS or not chosen.any():
            continue
        ratio = now[chosen].sum() / rest[chosen].sum()
        if abs(ratio - 1.0) > VOLUME_WITHIN:
            yield f"{name} at {ratio:.0%} of its volume"
    tangled = int((now[whole] <= 0.0).sum())
    if tangled:
        yield f"{tangled} elements inside out"


def wave_speed_m_s(world: World) -> float:
    """Return sqrt(E / rho) of the stiffest wall: recoiling tissue moves no faster."""
    stiffest = max(m.young_pa for m in MATERIALS.values()) * world.anatomy.stiffness_scale
    return float(np.sqrt(stiffest / DENSITY_KG_M3))


def _follow(world: World, commands) -> Iterator[StormSample]:
    for command in commands:
        world.step(command)
        sample = _measure(world)
        yield sample
        if not sample.finite:
            return


def _measure(world: World) -> StormSample:
    tissue = world.tissue
    n = tissue.n_vertex()
    position, velocity = (
        tissue.host(name)[0, :n].astype(float) for name in ("position", "velocity")
    )
    mass, rest = tissue.host("mass")[0, :n], tissue.host("volume")[0, : len(tissue.tets())]
    forces, volumes = world.tool_forces_n(), tissue.volumes()
    speed = np.linalg.norm(velocity, axis=1)
    observation = world.observe().vector()
    return StormSample(
        finite=all(np.isfinite(a).all() for a in (position, velocity, forces, observation)),
        tips_m=world.arms.T_world_tool()[:, :3, 3],
        commanded_m=_commanded_tips(world),
        tool=world.arms.mounted[RIGHT_ARM].name,
        tissue_speed_m_s=float(speed.max()),
        force_n=float(np.linalg.norm(forces, axis=1).max()),
        energy_j=float(tissue.elastic_energy_j()[0] + 0.5 * (mass * speed**2).sum()),
        height_energy_j=float(GRAVITY_M_S2 * (mass * position[:, 2]).sum()),
        volume=float(volumes.sum() / rest.sum()),
        inverted=int((volumes <= 0.0).sum()),
        touched=bool((tissue.host("contact_shape")[0, :n] >= 0).any()),
    )


def _commanded_tips(world: World) -> Array:
    rows = zip(world.arms.T_world_rcm, world.target, world.arms.mounted, strict=True)
    return np.stack([(T @ forward_kinematics(q[:6], tool))[:3, 3] for T, q, tool in rows])


def _speeds(world: World, samples: list[StormSample], tips: str) -> Array:
    """Return (n, 2) speeds of both tips, m/s, without exchanges of tools."""
    points = np.stack([getattr(m, tips) for m in samples])
    same = [a.tool == b.tool for a, b in pairwise(samples)]
    return np.linalg.norm(np.diff(points, axis=0)[same], axis=-1) / world.config.control_step_s


def _retreat(world: World) -> Iterator[JointCommand]:
    """Yield commands that open both jaws in place, then move both arms home."""
    opened = world.target
    opened[:, 6] = OPEN_RAD
    steps = _steps(world, RETREAT_S)
    for k in range(steps):
        share = np.clip(2 * (k + 1) / steps - 1, 0.0, 1.0)
        yield JointCommand(joints=opened + share * (_home().joints - opened))


def _home() -> JointCommand:
    return JointCommand(joints=np.tile(HOME_JOINTS, (2, 1)))


def _springs(world: World) -> int:
    """Return the number of intact ties and anchors."""
    names = ("tie_stiffness", "anchor_stiffness")
    return sum(int((world.tissue.host(name)[0] > 0.0).sum()) for name in names)


def _steps(world: World, time_s: float) -> int:
    return round(time_s / world.config.control_step_s)


def trial_table(trials: Sequence[StormTrial]) -> Table:
    """Return a table of the storms' effects and of the laws that they broke."""
    title = f"{len(trials)} storms, seeds {trials[0].seed} to {trials[-1].seed}"
    table = table_of(title, ("measured",), ("median", "p99", "max"), ())
    finished = [t for t in trials if np.isfinite(t.tip_speed_m_s)]
    measured = {
        "commanded tip speed, max of a storm (mm/s)": [
            1e3 * t.commanded_speed_m_s for t in finished
        ],
        "tip speed, p99 of a storm (mm/s)": [1e3 * t.tip_speed_m_s for t in finished],
        "fastest tissue (m/s)": [t.tissue_speed_m_s for t in finished],
        "force on a tool (N)": [t.force_n for t in finished],
        "energy in the tissue (mJ)": [1e3 * t.energy_j for t in finished],
        "volume lost in the storm (%)": [100 * (1 - t.volume[0]) for t in finished],
        "volume gained in the storm (%)": [100 * (t.volume[1] - 1) for t in finished],
        "elements inside out in the storm": [t.inverted for t in finished],
    }
    for name, values in measured.items() if finished else ():
        table.add_row(name, *(f"{x:.4g}" for x in np.percentile(values, [50, 99, 100])))
    table.add_section()
    for name in ("touched", "clipped", "cut", "torn", "detached", "caught"):
        share = sum(getattr(t, name) for t in trials) / len(trials)
        table.add_row(f"storms in which tissue was {name}", "", "", f"{share:.1%}")
    table.add_row("storms that broke a law", "", "", str(sum(bool(t.broken) for t in trials)))
    return table


def broken_lines(trials: Sequence[StormTrial]) -> list[str]:
    """Return a line for each storm that broke a law."""
    return [f"seed {t.seed}: {', '.join(t.broken)}" for t in trials if t.broken]


def caught_lines(trials: Sequence[StormTrial]) -> list[str]:
    """Return a line with the storms after which tissue is still held by a tool, if any."""
    seeds = [str(t.seed) for t in trials if t.caught]
    return [f"still caught on a tool: seeds {', '.join(seeds)}"] if seeds else []
