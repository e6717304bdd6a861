"""Check an organ, and lay it out in the kernels' arrays: sizes and initial values."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import warp as wp
from numpy.typing import NDArray

from tissue_sim.mechanics.arrays import TissueArrays, ToolShapes
from tissue_sim.mechanics.bar_contact import BALLS, BAR_VERTICES, N_BARS
from tissue_sim.mechanics.coarse_motion import MODES, parts_of, skyline_capacity
from tissue_sim.mechanics.topology import (
    boundary_faces,
    components,
    distances_to_triangles,
    encloses,
)
from tissue_sim.patient.at_risk import BRANCHES
from tissue_sim.patient.material import (
    ANCHOR_STIFFNESS,
    ANCHOR_STRENGTH,
    LIGAMENT_STIFFNESS,
    LIGAMENT_STRENGTH,
    ROOT_STIFFNESS,
    ROOT_STRENGTH,
    TIE_STIFFNESS,
    TIE_STRENGTH,
    lame_of,
)
from tissue_sim.patient.mesh_checks import require_indices, require_sound_elements
from tissue_sim.patient.mesher import Indices
from tissue_sim.patient.organ import REGIONS, Organ
from tissue_sim.patient.walls import collagen, n_patches, patch_stiffness, wall_pieces

HOST = "cpu"  # the device of the arrays, on which numpy shares their memory
SPARE_PARTS = 8  # a transection adds one
SPARE_VERTICES = 96  # vertices for cuts: a transection uses 13
LINK_CAPACITY = 512  # links for remnants and clips: a clip uses about 12
N_SHAPES = 8  # shaft, wrist and two jaws of two arms
NECK_RINGS = 2  # assumed: rings of the sac, 5 to 8 mm wide, which lie on one side of a finger
BLOCKS_A_ROW = 18  # blocks of the stiffness matrix: above the average of all meshes


def allocate(organs: Sequence[Organ]) -> tuple[TissueArrays, ToolShapes]:  # pyright: ignore[reportGeneralTypeIssues]
    """Return zeroed arrays with room for the largest organ, and the tools far away."""
    sizes, n_env = _sizes(organs), len(organs)
    arrays = TissueArrays()
    for name, var in TissueArrays.vars.items():
        shape = (n_env, *sizes.get(name, sizes["position"]))
        setattr(arrays, name, wp.zeros(shape, dtype=var.type.dtype, device=HOST))
    shapes = ToolShapes()
    for name, var in ToolShapes.vars.items():
        setattr(shapes, name, wp.zeros((n_env, N_SHAPES), dtype=var.type.dtype, device=HOST))
    shapes.a.numpy()[:] = 1.0
    shapes.b.numpy()[:] = 1.0
    shapes.T_world_link.numpy()[:] = np.eye(4)
    shapes.T_world_link_before.numpy()[:] = np.eye(4)
    return arrays, shapes


def starting_values(organ: Organ, stiffness_scale: float) -> dict[str, NDArray]:
    """Return an organ's initial arrays, by name; other arrays are zero or follow from them."""
    held_by = len(organ.bed_vertices), len(organ.ligament_vertices)
    mu, lam = lame_of(organ.region, REGIONS, stiffness_scale)
    fibre, stiff = collagen(organ, stiffness_scale)
    rings = _all_rings(organ)
    return {
        "n_vertex": np.array(len(organ.vertices)),
        "n_tet": np.array(len(organ.tets)),
        "position": organ.vertices,
        "rest": organ.vertices,
        "fixed": organ.fixed,
        "contact_shape": np.full(len(organ.vertices) + SPARE_VERTICES, -1),
        "strand_shape": np.full(LINK_CAPACITY, -1),
        "tet": organ.tets,
        "tet_alive": np.ones(len(organ.tets)),
        "mu": mu,
        "shear": mu,
        "lam": lam,
        "bulk": lam,
        "fibre": fibre,
        "collagen": stiff,
        "tie_corner": np.column_stack([organ.tie_vertex, organ.tie_corners]),
        "tie_weight": np.insert(-organ.tie_weights, 0, 1.0, axis=1),
        "tie_stiffness": np.where(organ.root_ties, ROOT_STIFFNESS, TIE_STIFFNESS),
        "tie_strength": np.where(organ.root_ties, ROOT_STRENGTH, TIE_STRENGTH),
        "anchor": organ.anchored,
        "anchor_point": organ.vertices[organ.anchored],
        "anchor_stiffness": np.repeat([ANCHOR_STIFFNESS, LIGAMENT_STIFFNESS], held_by),
        "anchor_strength": np.repeat([ANCHOR_STRENGTH, LIGAMENT_STRENGTH], held_by),
        "n_part": np.array(len(rings)),
        "part": parts_of(rings, len(organ.vertices)),
        "bed_point": organ.bed.point_m,
        "bed_normal": organ.bed.normal,
        "bed_along": organ.bed.along,
        "bed_edge": np.array(organ.bed.edge_m),
        "wall": wall_pieces(organ),
        "patch_stiffness": patch_stiffness(organ),
        **_tube_values(organ),
        **_skin_values(organ),
    }


def _tube_values(organ: Organ) -> dict[str, NDArray]:
    """Return the outer vertices of the tubes' rings, padded to the longest tube."""
    n_tube, n_ring = len(organ.hollow), max(len(rings) for rings in organ.rings.values())
    n_around = _around(organ)
    ring = np.zeros((n_tube, n_ring, n_around), np.int32)
    radius = np.zeros(n_tube)
    for k, rings in enumerate(organ.rings.values()):
        ring[k, : len(rings)] = rings[:, 1 + n_around :]
        spokes = organ.vertices[rings[:, 1 + n_around]] - organ.vertices[rings[:, 0]]
        radius[k] = np.linalg.norm(spokes, axis=1).mean()
    n_joined = np.array([organ.neck_ring[tube] + 1 for tube in organ.hollow])
    return {
        "ring": ring,
        "ring_above": ring,
        "n_ring": n_joined,
        "n_colliding": np.array(len(organ.tubes)),
        "tube_radius": radius,
        "neck": organ.sac_rings[:NECK_RINGS],
    }


def sac_skin(organ: Organ) -> Indices:
    """Return the triangles (n, 3) of the gallbladder's surface."""
    return boundary_faces(organ.tets[organ.region <= 1])[0]


def _skin_values(organ: Organ) -> dict[str, NDArray]:
    """Return the gallbladder's skin, and the rings that can touch it: rings beside it at rest.

    A ring that overlaps the gallbladder at rest is part of the tube's joint; ties hold the tube
    there.
    """
    skin, tubes = sac_skin(organ), _tube_values(organ)
    of_sac = np.flatnonzero(organ.region <= 1)
    skin_tet = of_sac[boundary_faces(organ.tets[of_sac])[1]]
    corners = organ.vertices[skin]
    beside = np.zeros(tubes["ring"].shape[:2], int)
    for k, tube in enumerate(organ.tubes if len(skin) else ()):
        centres = organ.vertices[organ.rings[tube][: tubes["n_ring"][k], 0]]
        for r in np.flatnonzero(~encloses(corners, centres)):
            distance_m = distances_to_triangles(corners, centres[r]).min()
            beside[k, r] = distance_m > tubes["tube_radius"][k]
    return {
        "skin": skin,
        "skin_tet": skin_tet,
        "n_skin": np.array(len(skin)),
        "ring_beside_sac": beside,
    }


def _all_rings(organ: Organ) -> list[Indices]:
    """Return the sections that the preconditioner moves as rigid bodies.

    Each trunk precedes its branch, and the sac is last, so the numbers of joined parts are close.
    """
    joined = [tube for pair in BRANCHES.items() for tube in pair if tube in organ.rings]
    others = [tube for tube in organ.hollow if tube not in joined]
    return [*(r for tube in joined + others for r in organ.rings[tube]), *organ.sac_rings]


def _around(organ: Organ) -> int:
    """Return the number of corners of a tube's ring."""
    return (next(iter(organ.rings.values())).shape[1] - 1) // 2


def _sizes(organs: Sequence[Organ]) -> dict[str, tuple[int, ...]]:
    """Return the shape of each array after its environment axis; other arrays are per vertex."""
    n_vertex = max(len(o.vertices) for o in organs) + SPARE_VERTICES
    n_tet = max(len(o.tets) for o in organs)
    n_tie = max(len(o.tie_vertex) for o in organs)
    n_anchor = max(len(o.anchored) for o in organs)
    n_ring = max(len(r) for o in organs for r in o.rings.values())
    n_tube = max(len(o.hollow) for o in organs)
    n_around = _around(organs[0])
    n_part = max(len(_all_rings(o)) for o in organs) + SPARE_PARTS
    n_patch = max(n_patches(o) for o in organs)
    n_skin = max(len(sac_skin(o)) for o in organs)
    segments = (n_tube, n_ring)
    carried, balls = (N_BARS, BAR_VERTICES), (N_BARS, BALLS)
    return {
        "position": (n_vertex,),
        "n_vertex": (), "n_tet": (), "bed_point": (), "bed_normal": (), "bed_along": (),
        "bed_edge": (), "bed_force": (), "iterations": (), "has_broken": (),
        "tet": (n_tet,), "tet_alive": (n_tet,), "rest_inverse": (n_tet,), "volume": (n_tet,),
        "mu": (n_tet,), "shear": (n_tet,), "bulk": (n_tet,), "folded": (n_tet,), "lam": (n_tet,),
        "fibre": (n_tet,), "collagen": (n_tet,),
        "tet_slot": (n_tet, 16),
        "tie_corner": (n_tie, 5), "tie_weight": (n_tie, 5), "tie_slot": (n_tie, 25),
        "tie_stiffness": (n_tie,), "tie_strength": (n_tie,),
        "link": (LINK_CAPACITY,), "link_rest": (LINK_CAPACITY,),
        "link_stiffness": (LINK_CAPACITY,), "link_strength": (LINK_CAPACITY,),
        "link_slot": (LINK_CAPACITY, 4),
        "strand_shape": (LINK_CAPACITY,), "strand_point": (LINK_CAPACITY,),
        "strand_normal": (LINK_CAPACITY,),
        "anchor": (n_anchor,), "anchor_point": (n_anchor,), "anchor_stiffness": (n_anchor,),
        "anchor_strength": (n_anchor,),
        "ring": (n_tube, n_ring, n_around), "ring_above": (n_tube, n_ring, n_around),
        "n_ring": (n_tube,), "n_colliding": (),
        "ring_centre": (n_tube, n_ring), "ring_centre_above": (n_tube, n_ring),
        "tube_radius": (n_tube,),
        "neck": (NECK_RINGS, max(o.sac_rings.shape[1] for o in organs)),
        "n_skin": (), "skin": (n_skin,), "skin_tet": (n_skin,), "n_skin_near": (),
        "skin_near": (n_skin,), "skin_middle": (n_skin,), "skin_reach": (n_skin,),
        "ring_beside_sac": segments,
        "n_bar": (), "bar_reach": (N_BARS,), "bar_radius": (N_BARS,), "bar_count": (N_BARS,),
        "bar_vertex": carried, "bar_middle": carried, "bar_axis": carried,
        "bar_scale": (N_BARS,), "bar_in_jaws": (N_BARS,), "bar_force": (N_BARS,),
        "ball": balls, "ball_before": balls, "ball_shape": balls, "ball_force": balls,
        "ball_stiffness": balls,
        "wall": (n_tet,), "segment_gradient": segments, "segment_direction": segments,
        "segment_volume": segments, "segment_pull": segments,
        "patch_shape": (n_patch,), "patch_volume": (n_patch,), "patch_stretch": (n_patch,),
        "patch_stiffness": (n_patch,),
        "row": (n_vertex + 1,), "column": (BLOCKS_A_ROW * n_vertex,),
        "block": (BLOCKS_A_ROW * n_vertex,), "elastic": (BLOCKS_A_ROW * n_vertex,),
        "stiffness_holds": (),
        "n_part": (), "part_middle": (n_part,), "part_count": (n_part,),
        "factor": (skyline_capacity(n_part),), "factor_first": (n_part,),
        "factor_start": (n_part + 1,), "factor_pivot": (MODES * n_part,),
        "motion": (n_part,),
    }  # fmt: skip


def require_sound_organ(organ: Organ) -> None:
    """Refuse an organ that has broken elements or an unsupported part.

    Ties and strands join parts. A single body may be free. Of several parts, each must be joined to
    the rest, or attached at fixed vertices, at the liver bed or by the ligament.

    Raises:
        ValueError: the organ is refused; the message names the element or the part.
    """
    require_sound_elements(organ.vertices, organ.tets)
    n = len(organ.vertices)
    for name in ("tie_vertex", "tie_corners", "bed_vertices", "ligament_vertices", "remnants"):
        require_indices(name, getattr(organ, name), n, "tissue")
    ties = np.column_stack([organ.tie_vertex, organ.tie_corners[:, 0]]).reshape(-1, 2)
    joints = np.concatenate([ties, organ.remnants]).astype(np.int32)
    label = components(n, np.concatenate([organ.tets, joints[:, [0, 1, 1, 1]]]))
    held = set(label[organ.fixed].tolist()) | set(label[organ.anchored].tolist())
    loose = set(label.tolist()) - held
    if loose and len(set(label.tolist())) > 1:
        part = np.flatnonzero(label == min(loose))
        raise ValueError(
            f"mesh of the tissue: the part of {len(part)} vertices around vertex {part[0]} is "
            "neither held nor joined to the rest"
        )
