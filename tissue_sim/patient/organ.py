"""Mesh gallbladder, cystic tubes and structures at risk as one connected finite-element system."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tissue_sim.frames import AWAY, RIGHT, UP, Array, field_point, unit
from tissue_sim.patient.at_risk import AT_RISK, BRANCHES, RADIUS_M, course
from tissue_sim.patient.mesh_checks import require_sound_elements
from tissue_sim.patient.mesher import Indices, Sweep, subdivide, sweep
from tissue_sim.patient.supports import LiverBed, back_of, fixed_vertices, liver_bed, lying_on, ties

if TYPE_CHECKING:
    from tissue_sim.patient.anatomy import Anatomy, Artery

PARTS = ("gallbladder", "duct", "artery", "second artery", *AT_RISK)
# the wall and the inside of each part; the regions of part k are 2 k and 2 k + 1
REGIONS = tuple(
    name
    for part in PARTS
    for name in (f"{part} wall", "bile" if part == "gallbladder" else f"{part} lumen")
)
TUBES = ("duct", "artery")  # the procedure's tubes, in every organ; `Organ.hollow` lists all

# Assumed: the sizes of the mesh, and where in the body the gallbladder lies and what holds it.
NECK_UP_M = 0.008  # height of the neck in the field
RING_SPACING_M = 0.00175  # between a tube's rings: a clip 2 mm wide always holds one
FEWEST_SEGMENTS = 4  # of a tube: below 5.25 mm its rings stand closer
INFUNDIBULUM_M = 0.015  # length of the sac, from the neck, that is free of the liver
FUNDUS_SPACING_M = 0.010
INFUNDIBULUM_SEGMENTS = 6
EMBEDDED_M = 0.004  # depth to which a tube's end reaches into the sac
SAC_SECTORS, TUBE_SECTORS = 10, 6
SAC_LUMEN, TUBE_LUMEN = 0.75, 0.5  # inner over outer radius
FAT_SPREAD = (0.25, 0.9)  # where fat joins the tubes, shares of their length from the fixed end


@dataclass(frozen=True, kw_only=True)
class Organ:
    """The rest mesh and its supports.

    Attributes:
        vertices: (n_vertex, 3), world frame, m.
        tets: (n_tet, 4) corners of the elements.
        region: (n_tet,), index into `REGIONS`.
        fixed: (n_vertex,), whether the body holds a vertex. The body holds the ends of the
            structures at risk, and of tubes that branch off none. The assistant's grasper, which
            moves with the body, holds the last ring of the sac: the fundus.
        rings: Tube name -> (n_ring, 1 + 2 sectors): centre, inner, outer. The rings of a cystic
            tube run from its far end up to the sac.
        neck_ring: Tube name -> index of the ring at the sac's wall, or of a trunk's last ring.
        sac_rings: (n_ring, 1 + 2 sectors), from the neck to the fundus.
        tie_vertex: (n_tie,), tube vertices tied into the sac, or into the wall of the tube's trunk.
        tie_corners: (n_tie, 4), corners of the tetrahedron at the tie.
        tie_weights: (n_tie, 4), weights of these corners.
        bed_vertices: (n_bed,), sac vertices that connective tissue holds to the liver.
        ligament_vertices: (n_ligament,), vertices at the back of the structures at risk, which the
            hepatoduodenal ligament holds.
        remnants: (n_remnant, 2), pairs of vertices that strands join; fat strands come last.
        bed: The liver bed.
    """

    vertices: Array
    tets: Indices
    region: Indices
    fixed: NDArray[np.bool_]
    rings: dict[str, Indices]
    neck_ring: dict[str, int]
    sac_rings: Indices
    tie_vertex: Indices
    tie_corners: Indices
    tie_weights: Array
    bed_vertices: Indices
    ligament_vertices: Indices
    remnants: Indices
    bed: LiverBed

    @property
    def hollow(self) -> tuple[str, ...]:
        """Return the names of everything that has rings; the procedure's `TUBES` come first."""
        return tuple(self.rings)

    @property
    def tubes(self) -> tuple[str, ...]:
        """Return the names of the cystic tubes, which end in the sac; `TUBES` come first."""
        return tuple(name for name in self.rings if name not in AT_RISK)

    @property
    def root_ties(self) -> NDArray[np.bool_]:
        """Return (n_tie,) whether a tie joins a branch to its trunk, and not a tube to the sac."""
        roots = [self.rings[branch][0] for branch in BRANCHES.values() if branch in self.rings]
        return np.isin(self.tie_vertex, roots)

    @property
    def anchored(self) -> Indices:
        """Return the vertices that springs hold to the body: the bed's, then the ligament's."""
        return np.concatenate([self.bed_vertices, self.ligament_vertices])


def build_organ(anatomy: Anatomy, *, refinement: int = 1) -> Organ:
    """Mesh the anatomy. This is a pure function: the same anatomy gives the same mesh.

    Args:
        anatomy: The patient.
        refinement: Number of parts into which each edge along and around the world's mesh is
            divided, for convergence studies. Ties and anchors then hold more vertices.

    Raises:
        ValueError: a part bends so sharply that an element is inverted or flat.
    """
    side = -1.0 if anatomy.artery_on_left else 1.0
    axis, radius = _sac_profile(anatomy)
    sac = sweep(
        subdivide(axis, refinement),
        subdivide(radius, refinement),
        sectors=refinement * SAC_SECTORS,
        lumen=SAC_LUMEN,
    )
    lines = {"duct": _duct_centreline(anatomy, side)}
    diameters = {"duct": anatomy.duct_diameter_m}
    for name, artery in anatomy.arteries.items():
        lines[name] = _artery_centreline(artery, side, axis, radius)
        diameters[name] = artery.diameter_m
    for trunk, branch in BRANCHES.items():
        line = course(trunk, lines[branch][0], side)
        lines[trunk] = line, len(line) - 1
        diameters[trunk] = 2.0 * RADIUS_M[trunk]
    tubes = {
        name: sweep(
            subdivide(line, refinement),
            np.full(refinement * (len(line) - 1) + 1, 0.5 * diameters[name]),
            sectors=refinement * TUBE_SECTORS,
            lumen=TUBE_LUMEN,
        )
        for name, (line, _) in lines.items()
    }
    necks = {name: refinement * neck for name, (_, neck) in lines.items()}
    return _join(anatomy, sac, tubes, necks, axis, refinement)


def _sac_profile(anatomy: Anatomy) -> tuple[Array, Array]:
    """Return the sac's axis (n, 3) from neck to fundus, and its radius (n,).

    The shape is assumed. The neck is 30 % wider than the duct, at least 2.4 mm in radius. The body
    is widest at 0.65 of the length. The axis turns into the bed's direction from 6 to 31 mm above
    the neck.
    """
    from scipy.interpolate import PchipInterpolator

    length, width = anatomy.gallbladder_length_m, anatomy.gallbladder_width_m
    n_body = int(np.ceil((length - INFUNDIBULUM_M) / FUNDUS_SPACING_M))
    stations = np.concatenate(
        [
            np.arange(INFUNDIBULUM_SEGMENTS) * INFUNDIBULUM_M / INFUNDIBULUM_SEGMENTS,
            np.linspace(INFUNDIBULUM_M, length, n_body + 1),
        ]
    )
    neck = max(0.65 * anatomy.duct_diameter_m, 0.0024)
    knots = [0.0, 0.005, 0.012, 0.4 * length, 0.65 * length, 0.9 * length, length]
    sizes = [neck, *(width * share for share in (0.13, 0.20, 0.46, 0.5, 0.36, 0.12))]
    radius = PchipInterpolator(knots, sizes)(stations)
    fine = np.linspace(0.0, length, 400)
    tilt = anatomy.bed_tilt_rad * _smoothstep((fine - 0.006) / 0.025)
    heading = np.cos(tilt)[:, None] * UP + np.sin(tilt)[:, None] * AWAY
    curve = np.cumsum(heading * (fine[1] - fine[0]), axis=0) - heading[0] * (fine[1] - fine[0])
    axis = np.stack([np.interp(stations, fine, curve[:, k]) for k in range(3)], axis=1)
    return axis + field_point(0.0, NECK_UP_M, 0.0), radius


def _duct_centreline(anatomy: Anatomy, side: float) -> tuple[Array, int]:
    """Return rings from the common bile duct to inside the neck, and the ring at the neck."""
    neck = field_point(0.0, NECK_UP_M, 0.0)
    down = -np.cos(anatomy.duct_angle_rad) * UP
    heading = down - side * np.sin(anatomy.duct_angle_rad) * RIGHT
    return _tube_centreline(
        neck,
        neck + EMBEDDED_M * UP,
        heading,
        anatomy.duct_length_m,
        anatomy.duct_slack,
        -side * RIGHT,
    )


def _artery_centreline(
    artery: Artery, side: float, axis: Array, radius: Array
) -> tuple[Array, int]:
    """Return rings from the hepatic artery to inside the sac's wall, and the ring at the wall."""
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(axis, axis=0), axis=1))])
    at = artery.insertion_m
    centre = np.array([np.interp(at, arc, axis[:, k]) for k in range(3)])
    outward = np.cos(artery.turn_rad) * side * RIGHT - np.sin(artery.turn_rad) * AWAY
    wall = centre + float(np.interp(at, arc, radius)) * outward
    heading = -np.cos(artery.angle_rad) * UP + side * np.sin(artery.angle_rad) * RIGHT
    heading = unit(heading + artery.depth_m / artery.length_m * AWAY)
    inside = wall - EMBEDDED_M * unit(outward - 0.4 * UP)
    return _tube_centreline(wall, inside, heading, artery.length_m, artery.slack, outward)


def _tube_centreline(
    joint: Array, inside: Array, heading: Array, length: float, slack: float, bow: Array
) -> tuple[Array, int]:
    """Return a slightly bowed line below the joint, as long as given, and a stub in the sac.

    The rings lie on a parabola, and the line from ring to ring has the length.
    """
    n = max(int(np.ceil(length / RING_SPACING_M)), FEWEST_SEGMENTS)
    t = np.linspace(1.0, 0.0, n + 1)[:, None]
    chord = length * (1.0 - slack)
    bow = unit(bow - (bow @ heading) * heading)
    line = joint + t * chord * heading + 4 * _sagitta(chord, length, n) * t * (1 - t) * bow
    stub = joint + np.linspace(0, 1, 3)[1:, None] * (inside - joint)
    return np.concatenate([line, stub]), n


def _sagitta(chord: float, length: float, n: int) -> float:
    """Return the height of a parabola over a chord whose `n` equal parts have a length together."""
    from scipy.optimize import root_scalar

    t = np.linspace(0.0, 1.0, n + 1)
    rise = np.diff(4.0 * t * (1.0 - t))

    def too_long(sagitta: float) -> float:
        return float(np.hypot(chord / n, sagitta * rise).sum()) - length

    if too_long(0.0) >= 0.0:
        return 0.0  # the tube is straight
    return float(root_scalar(too_long, bracket=(0.0, length), xtol=1e-15).root)


def _join(
    anatomy: Anatomy,
    sac: Sweep,
    tubes: dict[str, Sweep],
    neck_ring: dict[str, int],
    axis: Array,
    refinement: int,
) -> Organ:
    """Number the parts in one system and find the ties and strands that join them."""
    parts = {"gallbladder": sac, **tubes}
    for name, part in parts.items():
        require_sound_elements(part.vertices, part.tets, name)
    ends = np.cumsum([len(p.vertices) for p in parts.values()])
    starts = dict(zip(parts, [0, *ends[:-1]], strict=True))
    vertices = np.concatenate([p.vertices for p in parts.values()])
    tets = np.concatenate([p.tets + starts[n] for n, p in parts.items()]).astype(np.int32)
    region = np.concatenate(
        [2 * PARTS.index(n) + p.in_lumen.astype(np.int32) for n, p in parts.items()]
    ).astype(np.int32)
    rings = {n: (p.rings + starts[n]).astype(np.int32) for n, p in tubes.items()}
    walls = {n: p.tets[~p.in_lumen] + starts[n] for n, p in parts.items() if n in AT_RISK}
    holding = {"gallbladder": sac.tets + starts["gallbladder"], **walls}
    tie_vertex, corners, weights = ties(vertices, holding, rings, neck_ring)
    bed = liver_bed(anatomy, axis)
    body = sac.rings[refinement * (INFUNDIBULUM_SEGMENTS + 1) :, 1 + refinement * SAC_SECTORS :]
    return Organ(
        vertices=vertices,
        tets=tets,
        region=region,
        fixed=fixed_vertices(len(vertices), rings, sac.rings),
        rings=rings,
        neck_ring=neck_ring,
        sac_rings=sac.rings,
        tie_vertex=tie_vertex,
        tie_corners=corners,
        tie_weights=weights,
        bed_vertices=lying_on(bed, vertices, body.ravel()),
        ligament_vertices=np.concatenate([back_of(vertices, rings[trunk]) for trunk in AT_RISK]),
        remnants=np.concatenate(
            [
                _remnants(anatomy, rings, refinement),
                _fat_strands(anatomy, vertices, rings, neck_ring, sac.rings, refinement),
            ]
        ),
        bed=bed,
    )


def _remnants(anatomy: Anatomy, rings: dict[str, Indices], refinement: int) -> Indices:
    """Return the strands that the dissection left between duct and artery, near the sac."""
    outer = {name: _outer(r, TUBE_SECTORS, refinement) for name, r in rings.items()}
    rng = np.random.default_rng([0x57A2D, anatomy.seed])
    pairs = [
        (
            int(rng.choice(outer["duct"][-5 - int(rng.integers(0, 2))])),
            int(rng.choice(outer["artery"][-4 - int(rng.integers(0, 2))])),
        )
        for _ in range(anatomy.remnants)
    ]
    return np.array(pairs, dtype=np.int32).reshape(-1, 2)


def _fat_strands(
    anatomy: Anatomy,
    vertices: Array,
    rings: dict[str, Indices],
    neck_ring: dict[str, int],
    sac_rings: Indices,
    refinement: int,
) -> Indices:
    """Return strands across Calot's triangle.

    Two of three strands join duct and artery; the third joins one of these tubes to the sac.
    """
    outer = {tube: _outer(rings[tube], TUBE_SECTORS, refinement) for tube in TUBES}
    necks = {tube: neck_ring[tube] // refinement for tube in TUBES}
    sac = _outer(sac_rings, SAC_SECTORS, refinement)[1 : INFUNDIBULUM_SEGMENTS - 1].ravel()
    rng = np.random.default_rng([0xFA7, anatomy.seed])
    pairs = []
    for k in range(anatomy.fat_strands):
        share = rng.uniform(*FAT_SPREAD)
        walls = {tube: outer[tube][round(share * necks[tube])] for tube in TUBES}
        if k % 3 == 2:
            tube = TUBES[k // 3 % 2]
            below = max(necks[tube] - int(rng.integers(2, 6)), 1)  # short tubes: `FEWEST_SEGMENTS`
            pairs.append(_facing(vertices, outer[tube][below], sac, rng))
        else:
            pairs.append(_facing(vertices, walls["duct"], walls["artery"], rng))
    return np.array(pairs, dtype=np.int32).reshape(-1, 2)


def _outer(rings: Indices, sectors: int, refinement: int) -> Indices:
    """Return the outer vertices (n_ring, sectors) that the mesh has without refinement."""
    return rings[::refinement, 1 + refinement * sectors :: refinement]


def _facing(
    vertices: Array, first: Indices, second: Indices, rng: np.random.Generator
) -> tuple[int, int]:
    """Return one of the four closest pairs between two sets of vertices."""
    apart = np.linalg.norm(vertices[first][:, None] - vertices[second][None], axis=-1)
    chosen = np.argsort(apart, axis=None)[int(rng.integers(0, 4))]
    i, j = np.unravel_index(chosen, apart.shape)
    return int(first[i]), int(second[j])


def _smoothstep(x: Array) -> Array:
    x = np.clip(x, 0.0, 1.0)
    return x * x * (3.0 - 2.0 * x)
