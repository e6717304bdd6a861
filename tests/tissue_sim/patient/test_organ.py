"""Tests of the mesher and of the organ it builds: volumes, sizes, connections, repeatability."""

import re
from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.slow import slow
from tissue_sim.frames import AWAY, RIGHT, Array, unit
from tissue_sim.mechanics.layout import require_sound_organ
from tissue_sim.mechanics.topology import boundary_faces, components
from tissue_sim.patient.anatomy import COUNTS, RANGES, Anatomy, Artery, anatomy_from_seed
from tissue_sim.patient.at_risk import AT_RISK, BRANCHES, RADIUS_M, SPACING_M
from tissue_sim.patient.mesher import signed_volumes, sweep
from tissue_sim.patient.organ import (
    REGIONS,
    RING_SPACING_M,
    TUBE_SECTORS,
    TUBES,
    Organ,
    build_organ,
)
from tissue_sim.patient.textbook import textbook_from_seed

SEEDS = [*range(100), *range(20_000, 20_100)]


def polygon_area(sectors: int, radius: Array | float) -> Array | float:
    return 0.5 * sectors * np.sin(2 * np.pi / sectors) * radius**2


@settings(max_examples=30)
@given(
    sectors=st.integers(4, 12),
    lumen=st.floats(0.2, 0.9),
    radii=st.lists(st.floats(0.5, 2.0), min_size=2, max_size=6),
)
def test_a_straight_sweep_has_the_volume_of_its_frusta(
    sectors: int, lumen: float, radii: list[float]
) -> None:
    """Check the volume, which is exact if both ends are equal.

    Otherwise the diagonal of a side cuts off or adds part of a bilinear patch, (r - r')^2 in all.
    """
    r = np.array(radii)
    line = np.zeros((len(r), 3))
    line[:, 2] = np.arange(len(r))
    body = sweep(line, r, sectors=sectors, lumen=lumen)
    volumes = signed_volumes(body.vertices, body.tets)
    assert volumes.min() > 0
    frusta = polygon_area(sectors, 1.0) * (r[:-1] ** 2 + r[:-1] * r[1:] + r[1:] ** 2) / 3
    bound = polygon_area(sectors, 1.0) * (np.diff(r) ** 2).sum() + 1e-12
    assert abs(volumes.sum() - frusta.sum()) <= bound
    in_lumen = volumes[body.in_lumen].sum()
    assert abs(in_lumen - lumen**2 * frusta.sum()) <= bound


@settings(max_examples=30)
@given(bend_radius=st.floats(3.0, 20.0), sectors=st.integers(5, 12), segments=st.integers(8, 30))
def test_a_bent_sweep_has_the_volume_of_its_polygonal_tube(
    bend_radius: float, sectors: int, segments: int
) -> None:
    """Compare with Pappus's theorem: the volume is the area times the arc.

    The bound has three parts. A chord is shorter than its arc by a^2 / 24. Two sections inclined
    by an angle a give a prism's volume up to a^2, and the triangulated sides up to a r / R.
    """
    angle = np.linspace(0.0, np.pi / 2, segments + 1)
    line = bend_radius * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    body = sweep(line, np.ones(segments + 1), sectors=sectors, lumen=0.5)
    volumes = signed_volumes(body.vertices, body.tets)
    assert volumes.min() > 0
    expected = polygon_area(sectors, 1.0) * bend_radius * np.pi / 2
    a = angle[1]
    assert volumes.sum() == pytest.approx(expected, rel=2 * a**2 + a / bend_radius)


def test_a_swept_surface_is_closed() -> None:
    line = np.stack([np.linspace(0, 1, 6)] * 3, axis=1)
    body = sweep(line, np.full(6, 0.2), sectors=7, lumen=0.5)
    faces, _ = boundary_faces(body.tets)
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    assert {tuple(e) for e in edges.tolist()} == {tuple(e) for e in edges[:, ::-1].tolist()}
    assert len(np.unique(faces)) - len(edges) // 2 + len(faces) == 2


@pytest.fixture(scope="module")
def organs() -> dict[int, Organ]:
    return {seed: build_organ(anatomy_from_seed(seed)) for seed in SEEDS}


def test_every_seed_meshes_without_a_flat_element(organs: dict[int, Organ]) -> None:
    for organ in organs.values():
        volumes = signed_volumes(organ.vertices, organ.tets)
        edges = organ.vertices[organ.tets[:, 1:]] - organ.vertices[organ.tets[:, :1]]
        longest = np.linalg.norm(edges, axis=-1).max(axis=1)
        assert (volumes / longest**3).min() > 1e-4
        assert np.isfinite(organ.vertices).all()
        tubes = [name for t in organ.hollow for name in (f"{t} wall", f"{t} lumen")]
        assert [REGIONS[k] for k in np.unique(organ.region)] == ["gallbladder wall", "bile", *tubes]
        assert set(np.unique(organ.tets)) == set(range(len(organ.vertices)))
        # float32 keeps it: the shortest edge is far longer than a rounding of the coordinates
        assert volumes.astype(np.float32).min() > 0


def test_sac_and_tubes_are_one_connected_part_each(organs: dict[int, Organ]) -> None:
    for organ in organs.values():
        label = components(len(organ.vertices), organ.tets)
        assert len(np.unique(label)) == 1 + len(organ.hollow)
        for tube in organ.hollow:
            assert len(np.unique(label[organ.rings[tube]])) == 1
        assert len(np.unique(label[organ.sac_rings])) == 1


def test_tubes_have_the_length_and_width_of_the_anatomy(organs: dict[int, Organ]) -> None:
    """Measure the length along the rings' centres, which lie on a bow."""
    for seed, organ in organs.items():
        patient = anatomy_from_seed(seed)
        for tube in TUBES:
            length = getattr(patient, f"{tube}_length_m")
            slack = getattr(patient, f"{tube}_slack")
            rings = organ.rings[tube][: organ.neck_ring[tube] + 1]
            centres = organ.vertices[rings[:, 0]]
            spacing = np.linalg.norm(np.diff(centres, axis=0), axis=1)
            assert spacing.sum() == pytest.approx(length, rel=1e-12)
            straight = np.linalg.norm(centres[-1] - centres[0])
            assert straight == pytest.approx(length * (1 - slack), rel=1e-9)
            assert spacing.max() < 1.25 * RING_SPACING_M  # a bow is longer at its ends
            outer = organ.vertices[rings[:, 1 + TUBE_SECTORS :]]
            across = np.linalg.norm(outer[:, :3] - outer[:, 3:], axis=-1)  # opposite corners
            np.testing.assert_allclose(across, getattr(patient, f"{tube}_diameter_m"), rtol=1e-9)


def test_tubes_lie_clear_of_each_other_at_rest(organs: dict[int, Organ]) -> None:
    """Check distances between rings' centres; what lies between two rings may be 0.2 mm nearer."""
    for seed, organ in organs.items():
        patient = anatomy_from_seed(seed)
        radius_m = {name: 0.5 * a.diameter_m for name, a in patient.arteries.items()}
        radius_m["duct"] = 0.5 * patient.duct_diameter_m
        line = {t: organ.vertices[organ.rings[t][: organ.neck_ring[t] + 1, 0]] for t in organ.tubes}
        for k, one in enumerate(organ.tubes):
            for other in organ.tubes[:k]:
                apart = np.linalg.norm(line[one][:, None] - line[other][None], axis=-1).min()
                assert apart > radius_m[one] + radius_m[other] + 0.0005


@pytest.mark.parametrize("fat", [0, 22])
def test_strands_of_the_shortest_tubes_end_between_fixed_end_and_neck(fat: int) -> None:
    least = {name: RANGES[name].least for name in ("duct_length_m", "artery_length_m")}
    for seed in SEEDS[:20]:
        patient = replace(anatomy_from_seed(seed), **least, remnants=6, fat_strands=fat)
        organ = build_organ(patient)
        require_sound_organ(organ)
        ends = set(organ.remnants.ravel().tolist())
        for tube in TUBES:
            rings = organ.rings[tube]
            outside = np.concatenate([rings[:1], rings[organ.neck_ring[tube] + 1 :]])
            assert not ends & set(outside.ravel().tolist())


def test_the_sac_has_the_length_and_width_of_the_anatomy(organs: dict[int, Organ]) -> None:
    """Allow a length that is a little short, and a width that misses the profile's maximum.

    The axis is a polyline inscribed in a curve that turns by at most 0.9 rad.
    """
    for seed, organ in organs.items():
        patient = anatomy_from_seed(seed)
        axis = organ.vertices[organ.sac_rings[:, 0]]
        length = np.linalg.norm(np.diff(axis, axis=0), axis=1).sum()
        assert length == pytest.approx(patient.gallbladder_length_m, rel=0.02)
        assert length <= patient.gallbladder_length_m * 1.001
        n = (organ.sac_rings.shape[1] - 1) // 2
        radii = np.linalg.norm(organ.vertices[organ.sac_rings[:, 1 + n :]] - axis[:, None], axis=-1)
        widest = 2 * radii.max()
        assert 0.95 * patient.gallbladder_width_m < widest <= 1.001 * patient.gallbladder_width_m


def test_ties_hold_points_of_the_sac(organs: dict[int, Organ]) -> None:
    """Check that the weights sum to one and reproduce the point.

    A tube's line lies inside the sac. Its wall may lie a little beside the neck. There, a point is
    tied to the nearest element by extrapolation.
    """
    for organ in organs.values():
        weights, corners = organ.tie_weights, organ.vertices[organ.tie_corners]
        np.testing.assert_allclose(weights.sum(axis=1), 1.0, atol=1e-9)
        held = np.einsum("nk,nkx->nx", weights, corners)
        np.testing.assert_allclose(held, organ.vertices[organ.tie_vertex], atol=1e-9)
        n = (organ.rings["duct"].shape[1] - 1) // 2
        ends = [organ.rings[t][organ.neck_ring[t] + 1 :, 0] for t in organ.tubes]
        centres = np.concatenate(ends)
        assert n == TUBE_SECTORS
        inside = weights[np.isin(organ.tie_vertex, centres)]
        assert inside.min() > -0.05
        assert weights.min() > -1.0
        held_by = organ.sac_rings, *(organ.rings[trunk] for trunk in AT_RISK)
        holding = np.concatenate([rings.ravel() for rings in held_by])
        assert np.isin(organ.tie_corners, holding).all()
        assert not np.isin(organ.tie_vertex, holding).any()


def test_a_branch_is_tied_to_its_trunk_and_to_nothing_else(organs: dict[int, Organ]) -> None:
    for organ in organs.values():
        for trunk, branch in BRANCHES.items():
            roots = np.isin(organ.tie_vertex, organ.rings[branch][0])
            outer = organ.rings[branch][0, 1 + TUBE_SECTORS :]
            assert set(organ.tie_vertex[roots]) == set(outer[::2])  # a wall joins a wall
            walls = np.sort(organ.tets[organ.region == REGIONS.index(f"{trunk} wall")]).tolist()
            assert all(held in walls for held in np.sort(organ.tie_corners[roots], axis=1).tolist())
            root = organ.vertices[organ.rings[branch][0, 0]]
            apart = np.linalg.norm(organ.vertices[organ.rings[trunk][:, 0]] - root, axis=1).min()
            assert RADIUS_M[trunk] <= apart + 3e-4 < RADIUS_M[trunk] + 0.5 * SPACING_M


def test_the_ends_of_the_structures_at_risk_are_fixed_those_of_a_loose_artery_and_the_fundus(
    organs: dict[int, Organ],
) -> None:
    for organ in organs.values():
        held = [organ.rings[trunk][[0, -1]].ravel() for trunk in AT_RISK]
        held += [organ.rings[tube][0] for tube in set(organ.tubes) - set(BRANCHES.values())]
        ends = np.concatenate([*held, organ.sac_rings[-1]])  # the assistant holds the fundus
        np.testing.assert_array_equal(np.flatnonzero(organ.fixed), np.sort(ends))


def test_the_ligament_holds_the_backs_of_the_structures_at_risk(organs: dict[int, Organ]) -> None:
    for organ in organs.values():
        for trunk in AT_RISK:
            rings = organ.rings[trunk]
            held = np.isin(rings, organ.ligament_vertices)
            assert not held[[0, -1]].any()
            assert held[1:-1].sum(axis=1).min() >= 2
            depth = organ.vertices[rings] @ AWAY
            assert (depth > depth[:, :1])[held].all()


def test_the_bed_holds_the_body_and_not_the_neck(organs: dict[int, Organ]) -> None:
    for organ in organs.values():
        assert len(organ.bed_vertices) >= 10
        assert np.isin(organ.bed_vertices, organ.sac_rings[7:]).all()
        R = np.stack(
            [np.cross(organ.bed.normal, organ.bed.along), organ.bed.normal, organ.bed.along]
        )
        np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)


def test_strands_join_duct_to_artery(organs: dict[int, Organ]) -> None:
    for seed, organ in organs.items():
        patient = anatomy_from_seed(seed)
        assert organ.remnants.shape == (patient.remnants + patient.fat_strands, 2)
        near_the_sac = organ.remnants[: patient.remnants]
        assert np.isin(near_the_sac[:, 0], organ.rings["duct"]).all()
        assert np.isin(near_the_sac[:, 1], organ.rings["artery"]).all()


@pytest.mark.parametrize("refinement", [2, slow(3)])
def test_a_refined_mesh_has_its_strands_at_the_same_rings(refinement: int) -> None:
    """Compare the outer rings that strands end on; which of a ring's corners it is may be a tie."""
    for seed in SEEDS[:4]:
        patient = replace(anatomy_from_seed(seed), remnants=6, fat_strands=22)
        coarse, fine = build_organ(patient), build_organ(patient, refinement=refinement)
        for organ, parts in ((coarse, 1), (fine, refinement)):
            lines = (*(organ.rings[tube] for tube in TUBES), organ.sac_rings)
            outer = [rings[:, 1 + (rings.shape[1] - 1) // 2 :] for rings in lines]
            assert np.isin(organ.remnants, np.concatenate([o.ravel() for o in outer])).all()
            assert ring_numbers(organ, parts) == ring_numbers(coarse, 1)


def ring_numbers(organ: Organ, parts: int) -> list[list[tuple[str, float]]]:
    """Return for each strand the tubes that it ends on, and at which ring of the coarse mesh."""
    return [
        [
            (tube, int(np.argwhere((organ.rings[tube] == end).any(axis=1))[0, 0]) / parts)
            for end in ends
            for tube in TUBES
            if end in organ.rings[tube]
        ]
        for ends in organ.remnants.tolist()
    ]


def test_the_artery_lies_on_the_side_the_anatomy_says(organs: dict[int, Organ]) -> None:
    for seed, organ in organs.items():
        duct, artery = (organ.vertices[organ.rings[t][0, 0]] @ RIGHT for t in TUBES)
        assert (artery < duct) == anatomy_from_seed(seed).artery_on_left


def test_the_same_seed_gives_the_same_mesh_and_another_seed_another(
    organs: dict[int, Organ],
) -> None:
    for seed in SEEDS[:5]:
        again = build_organ(anatomy_from_seed(seed))
        for name in ("vertices", "tets", "fixed", "tie_corners", "tie_weights", "remnants"):
            np.testing.assert_array_equal(getattr(again, name), getattr(organs[seed], name))
    shapes = {round(float(o.vertices.sum()), 12) for o in organs.values()}
    assert len(shapes) == len(organs)


SHARES = st.floats(0.0, 1.0)


@settings(max_examples=60)
@given(
    shares=st.fixed_dictionaries(dict.fromkeys(RANGES, SHARES)),
    second=st.none() | st.fixed_dictionaries({f.name: SHARES for f in fields(Artery)}),
    fat=st.integers(0, int(COUNTS["fat_strands"].most)),
    on_left=st.booleans(),
)
def test_any_possible_anatomy_is_meshed_soundly_or_refused(
    shares: dict[str, float], second: dict[str, float] | None, fat: int, on_left: bool
) -> None:
    def within(name: str, share: float) -> float:
        r = RANGES[name]
        return min(r.least + share * (r.most - r.least), r.most)

    parameters = {name: within(name, share) for name, share in shares.items()}
    deep = {k: within(f"artery_{k}", share) for k, share in (second or {}).items()}
    refusal = ""
    try:
        patient = replace(
            anatomy_from_seed(0),
            **parameters,
            second_artery=Artery(**deep) if second else None,
            fat_strands=fat,
            artery_on_left=on_left,
        )
        organ = build_organ(patient)
    except ValueError as error:
        refusal = str(error)
    if refusal:
        assert re.match(r"anatomy: \w+ = |mesh of the [\w ]+: element \d+ ", refusal)
        return
    require_sound_organ(organ)
    assert signed_volumes(organ.vertices, organ.tets).min() > 0
    assert len(organ.tubes) == (3 if second else 2)
    assert len(organ.remnants) == patient.remnants + fat


def test_a_longer_duct_is_longer_and_leaves_the_artery_alone() -> None:
    patient = textbook_from_seed(0)
    longer = replace(patient, duct_length_m=patient.duct_length_m + 0.007)
    short, long = build_organ(patient), build_organ(longer)
    assert long.neck_ring["duct"] == short.neck_ring["duct"] + 4
    np.testing.assert_array_equal(
        short.vertices[short.rings["artery"]], long.vertices[long.rings["artery"]]
    )
    heading = [
        unit(o.vertices[o.rings["duct"][0, 0]] - o.vertices[o.rings["duct"][-3, 0]])
        for o in (short, long)
    ]
    np.testing.assert_allclose(*heading, atol=1e-9)


@pytest.mark.parametrize(
    "patient",
    [*map(anatomy_from_seed, range(60)), textbook_from_seed(6344), textbook_from_seed(6941)],
    ids=lambda patient: patient.seed,
)
def test_no_section_cuts_through_the_next_one(patient: Anatomy) -> None:
    """Check bends where the steps grow: there, oblique sections could fold the elements."""
    organ = build_organ(patient)
    for rings in (*organ.rings.values(), organ.sac_rings):
        x = organ.vertices[rings]
        centre, outer = x[:, 0], x[:, 1 + (x.shape[1] - 1) // 2 :]
        normal = np.cross(outer[:, 0] - centre, outer[:, 1] - centre)
        normal *= np.sign(np.einsum("ri,ri->r", normal[:-1], np.diff(centre, axis=0)))[[0]]
        ahead = np.einsum("rki,ri->rk", outer[1:] - centre[:-1, None], normal[:-1])
        behind = np.einsum("rki,ri->rk", outer[:-1] - centre[1:, None], normal[1:])
        assert (ahead > 0.0).all()
        assert (behind < 0.0).all()
