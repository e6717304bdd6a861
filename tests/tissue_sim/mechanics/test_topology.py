"""Tests of the mesh's connections: matrix pattern, surface, and splitting of vertices."""

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from tests.tissue_sim.bodies import rod
from tests.tissue_sim.verification.bodies import box
from tissue_sim.mechanics.topology import block_pattern, boundary_faces, components, part_vertices
from tissue_sim.patient.mesher import Indices, section_triangles, signed_volumes

N_VERTEX = 9
EVEN = np.array(
    [p for p in permutations(range(4)) if np.linalg.det(np.eye(4)[list(p)]) > 0]
)  # the rotations of a tetrahedron, which keep its volume positive


def elements(corners: int) -> st.SearchStrategy[Indices]:
    """Return some elements with this number of corners, each corner once."""
    one = st.permutations(range(N_VERTEX)).map(lambda p: p[:corners])
    return st.lists(one, max_size=6).map(
        lambda rows: np.array(rows, np.int32).reshape(len(rows), corners)
    )


@settings(max_examples=100)
@given(
    tets=elements(4),
    links=elements(2),
    values=hnp.arrays(np.float64, (12, 16), elements=st.floats(-9, 9)),
)
def test_block_pattern_assembles_the_dense_matrix(
    tets: Indices, links: Indices, values: np.ndarray
) -> None:
    row, column, slots = block_pattern(N_VERTEX, [tets, links])
    dense = np.zeros((N_VERTEX, N_VERTEX))
    block = np.zeros(len(column))
    for group, slot in zip((tets, links), slots, strict=True):
        k = group.shape[1]
        for corners, places, value in zip(group, slot, values, strict=False):
            local = value[: k * k].reshape(k, k)
            dense[np.ix_(corners, corners)] += local
            np.add.at(block, places, local.ravel())
    sparse = np.zeros_like(dense)
    for i in range(N_VERTEX):
        columns = column[row[i] : row[i + 1]]
        assert columns[0] == i  # the diagonal comes first
        assert len(set(columns.tolist())) == len(columns)
        sparse[i, columns] = block[row[i] : row[i + 1]]
    np.testing.assert_allclose(sparse, dense, atol=1e-12)
    coupled = {(i, i) for i in range(N_VERTEX)} | {
        (int(i), int(j)) for g in (tets, links) for e in g for i in e for j in e
    }
    assert len(column) == len(coupled)


@settings(max_examples=20)
@given(cells=st.tuples(*[st.integers(1, 3)] * 3))
def test_the_boundary_of_a_box_is_a_closed_outward_surface(cells: tuple[int, int, int]) -> None:
    vertices, tets = box((1.0, 2.0, 3.0), cells)
    turned = np.random.default_rng(0).integers(len(EVEN), size=len(tets))
    tets = np.take_along_axis(tets, EVEN[turned], axis=1)  # any corner may come first
    faces, owner = boundary_faces(tets)
    halves = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    directed = {tuple(h) for h in halves.tolist()}
    assert len(directed) == len(halves)  # each edge once in this direction
    assert directed == {(b, a) for a, b in directed}  # and once in the other
    n_edge = len(halves) // 2
    assert len(np.unique(faces)) - n_edge + len(faces) == 2  # Euler: a sphere
    # the volume by the divergence theorem, positive only when every face looks outward
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    assert np.einsum("ij,ij->i", np.cross(a, b), c).sum() / 6 == pytest.approx(6.0)
    assert all(np.isin(f, tets[o]).all() for f, o in zip(faces, owner, strict=True))


def cut_rod(share: float) -> tuple[Indices, Indices, list[int], int]:
    """Sever the faces of a rod's middle ring where y is in the given lower share."""
    tube = rod()
    ring = tube.rings[len(tube.rings) // 2]
    y = tube.vertices[ring, 1]
    under = y <= np.quantile(y, share)
    severed = {
        tuple(sorted(int(v) for v in ring[face]))
        for face in section_triangles((len(ring) - 1) // 2)
        if under[face].all()
    }
    n = len(tube.vertices)
    tets, parents = part_vertices(tube.tets, severed, ring.tolist(), n)
    return tube.tets, tets, parents, n


def n_parts(tets: Indices, n_vertex: int) -> int:
    return len(np.unique(components(n_vertex, tets)[np.unique(tets)]))


def test_a_severed_rod_is_in_two_parts() -> None:
    old, new, parents, n = cut_rod(1.0)
    assert n_parts(old, n) == 1
    assert n_parts(new, n + len(parents)) == 2
    assert len(parents) == len(set(parents)) == rod().rings.shape[1]


@pytest.mark.parametrize("share", [0.0, 0.5, 0.8])
def test_a_rod_cut_in_part_stays_in_one_part(share: float) -> None:
    _, new, parents, n = cut_rod(share)
    assert n_parts(new, n + len(parents)) == 1
    if share >= 0.5:
        assert parents  # it is open where it was cut


@pytest.mark.parametrize("share", [0.5, 1.0])
def test_splitting_moves_no_element(share: float) -> None:
    """Check that each new vertex has its parent's position, so every corner keeps its place."""
    old, new, parents, n = cut_rod(share)
    origin = np.concatenate([np.arange(n), parents])
    np.testing.assert_array_equal(origin[new], old)
    vertices = rod().vertices
    volumes = signed_volumes(np.concatenate([vertices, vertices[parents]]), new)
    np.testing.assert_array_equal(volumes, signed_volumes(vertices, old))
    assert set(np.unique(new)) == set(
        range(n + len(parents))
    )  # no vertex is left without an element


def test_without_severed_faces_nothing_is_split() -> None:
    tube = rod()
    tets, parents = part_vertices(tube.tets, set(), list(range(len(tube.vertices))), 99)
    assert parents == []
    np.testing.assert_array_equal(tets, tube.tets)


def test_a_cut_opens_the_surface_by_twice_the_section() -> None:
    old, new, _, _ = cut_rod(1.0)
    section = len(section_triangles((rod().rings.shape[1] - 1) // 2))
    assert len(boundary_faces(new)[0]) == len(boundary_faces(old)[0]) + 2 * section
