"""Tests of the mesh check: it refuses, by name, exactly the meshes that cannot be simulated."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from tests.tissue_sim.bodies import rod
from tests.tissue_sim.verification.bodies import box, organ_of
from tissue_sim.frames import Array
from tissue_sim.mechanics.layout import require_sound_organ
from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.patient.anatomy import anatomy_from_seed
from tissue_sim.patient.mesh_checks import require_sound_elements
from tissue_sim.patient.mesher import Indices
from tissue_sim.patient.organ import Organ, build_organ

Mesh = tuple[Array, Indices]


def swapped_corners(vertices: Array, tets: Indices) -> Mesh:
    tets[7] = tets[7][[1, 0, 2, 3]]
    return vertices, tets


def flattened(vertices: Array, tets: Indices) -> Mesh:
    a, b, c, d = tets[7]
    vertices[d] = (vertices[a] + vertices[b] + vertices[c]) / 3
    return vertices, tets


def collapsed(vertices: Array, tets: Indices) -> Mesh:
    tets[7] = tets[7, 0]
    return vertices, tets


def index_beyond(vertices: Array, tets: Indices) -> Mesh:
    tets[7, 2] = len(vertices)
    return vertices, tets


def index_below(vertices: Array, tets: Indices) -> Mesh:
    tets[7, 2] = -1
    return vertices, tets


def not_a_number(vertices: Array, tets: Indices) -> Mesh:
    vertices[3, 1] = np.nan
    return vertices, tets


def infinite(vertices: Array, tets: Indices) -> Mesh:
    vertices[3, 1] = np.inf
    return vertices, tets


def spare_vertex(vertices: Array, tets: Indices) -> Mesh:
    return np.concatenate([vertices, [[0.0, 0.0, 0.0]]]), tets


BREAKS: dict[Callable[[Array, Indices], Mesh], str] = {
    swapped_corners: "element 7 .* is inverted",
    flattened: r"element \d+ .* is (flat|inverted)",
    collapsed: "element 7 .* is flat",
    index_beyond: r"tets\[7\] = .* is out of range: there are 27 vertices",
    index_below: r"tets\[7\] = .* is out of range",
    not_a_number: "vertex 3 is at .* not finite",
    infinite: "vertex 3 is at .* not finite",
    spare_vertex: "vertex 27 belongs to no element",
}


@pytest.mark.parametrize("broken", BREAKS, ids=lambda f: f.__name__)
def test_a_broken_mesh_is_refused_and_the_message_names_the_fault(
    broken: Callable[[Array, Indices], Mesh],
) -> None:
    vertices, tets = box((0.02, 0.02, 0.02), (2, 2, 2))
    require_sound_elements(vertices, tets)
    vertices, tets = broken(vertices, tets)
    with pytest.raises(ValueError, match=f"mesh of the rod: {BREAKS[broken]}"):
        require_sound_elements(vertices, tets, "rod")
    with pytest.raises(ValueError, match=BREAKS[broken]):
        Tissue([organ_of(vertices, tets)])


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_the_size_of_a_mesh_does_not_matter(scale: float) -> None:
    body = rod()
    require_sound_elements(scale * body.vertices, body.tets)


def two_rods() -> Organ:
    body = rod()
    n = len(body.vertices)
    apart = body.vertices + np.array([0.0, 0.01, 0.0])
    organ = organ_of(
        np.concatenate([body.vertices, apart]), np.concatenate([body.tets, body.tets + n])
    )
    fixed = np.zeros(2 * n, bool)
    fixed[body.rings[0]] = True
    return replace(organ, fixed=fixed)


def test_a_part_that_nothing_holds_is_refused() -> None:
    organ = two_rods()
    n = len(organ.vertices) // 2
    with pytest.raises(ValueError, match=f"part of {n} vertices around vertex {n} is neither held"):
        require_sound_organ(organ)
    strand = np.array([[0, n]], np.int32)
    tie = {
        "tie_vertex": np.array([n], np.int32),
        "tie_corners": organ.tets[:1],
        "tie_weights": np.full((1, 4), 0.25),
    }
    held = organ.fixed.copy()
    held[n] = True
    require_sound_organ(replace(organ, remnants=strand))
    require_sound_organ(replace(organ, bed_vertices=np.array([n], np.int32)))
    require_sound_organ(replace(organ, fixed=held))
    require_sound_organ(replace(organ, **tie))


def test_a_single_body_may_be_free() -> None:
    body = rod()
    require_sound_organ(organ_of(body.vertices, body.tets))


@pytest.mark.parametrize(
    "name", ["tie_vertex", "tie_corners", "bed_vertices", "ligament_vertices", "remnants"]
)
def test_joints_must_refer_to_existing_vertices(name: str) -> None:
    organ = build_organ(replace(anatomy_from_seed(0), remnants=3))
    require_sound_organ(organ)
    wrong = getattr(organ, name).copy()
    wrong[-1] = len(organ.vertices)
    with pytest.raises(ValueError, match=rf"{name}\[{len(wrong) - 1}\] = .* is out of range"):
        require_sound_organ(replace(organ, **{name: wrong}))
