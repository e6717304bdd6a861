"""Tests of the anatomical variants: the meaning of each name holds for every seed."""

from dataclasses import asdict, replace

import numpy as np
import pytest

from tests.tissue_sim.bodies import forces
from tests.tissue_sim.kinds import POLYMER
from tests.tissue_sim.verification.bodies import EPS, astride, put, tissue_of
from tissue_sim.frames import AWAY, RIGHT, UP, Array, unit
from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.outcome.clip_rule import needed_m
from tissue_sim.patient.anatomy import Anatomy, anatomy_from_seed
from tissue_sim.patient.organ import Organ, build_organ
from tissue_sim.patient.textbook import TEXTBOOK, textbook_from_seed
from tissue_sim.patient.tubes import Tubes
from tissue_sim.patient.variants import VARIANTS, patient_of, variant
from tissue_sim.rendering.drawn_strands import holding
from tissue_sim.surgery.clip import latch
from tissue_sim.surgery.cut import BLADE_LENGTH_M, sever
from tissue_sim.surgery.leak import leaks
from tissue_sim.tools.instruments import applier_for
from tissue_sim.world import World

SEEDS = range(10_000, 10_020)
NAMED = ("two-arteries", "artery-in-front", "artery-behind", "swapped", "low-insertion")
CROSSING = ("artery-in-front", "artery-behind")


def line(organ: Organ, tube: str) -> Array:
    """Return dense points (n, 3) on a tube's centreline, up to the sac."""
    centres = organ.vertices[organ.rings[tube][: organ.neck_ring[tube] + 1, 0]]
    at, k = np.linspace(0, len(centres) - 1, 300), np.arange(len(centres))
    return np.stack([np.interp(at, k, centres[:, i]) for i in range(3)], axis=1)


def radius_m(patient: Anatomy, tube: str) -> float:
    widths = {"duct": patient.duct_diameter_m}
    widths |= {name: artery.diameter_m for name, artery in patient.arteries.items()}
    return 0.5 * widths[tube]


@pytest.mark.parametrize("name", VARIANTS)
def test_a_variant_is_a_pure_function_of_the_patient(name: str) -> None:
    for seed in SEEDS:
        patient = textbook_from_seed(seed)
        assert variant(name, patient) == variant(name, patient) == patient_of(seed, name)
        if name == "textbook":
            assert variant(name, patient) == patient
        elif name != "swapped" or not patient.artery_on_left:
            assert variant(name, patient).hash != patient.hash


@pytest.mark.parametrize("name", VARIANTS)
def test_a_variant_changes_only_its_own_parameters(name: str) -> None:
    chosen = VARIANTS[name]
    own = {*chosen.drawn, *chosen.fixed} | ({"second_artery"} if chosen.second_artery else set())
    for seed in SEEDS:
        patient = textbook_from_seed(seed)
        before, after = asdict(patient), asdict(variant(name, patient))
        assert {k for k in before if before[k] != after[k]} <= own
        for parameter, (low, high) in chosen.drawn.items():
            assert low <= after[parameter] <= high
    drawn = [tuple(asdict(variant(name, textbook_from_seed(s)))[k] for k in own) for s in SEEDS]
    assert len(set(map(str, drawn))) > 5 or not (chosen.drawn or chosen.second_artery)


def test_without_a_variant_the_patient_is_one_of_the_population() -> None:
    for seed in SEEDS:
        assert patient_of(seed, None) == anatomy_from_seed(seed) != textbook_from_seed(seed)


@pytest.mark.parametrize("name", NAMED)
def test_an_uncommon_course_is_named_by_the_anatomy(name: str) -> None:
    for seed in SEEDS:
        patient = textbook_from_seed(seed)
        assert patient.variant == ("swapped" if patient.artery_on_left else "usual")
        assert variant(name, replace(patient, artery_on_left=False)).variant == name


def test_an_unknown_variant_is_refused() -> None:
    with pytest.raises(
        ValueError, match="unknown variant 'two-ducts'; allowed: textbook, short-duct, "
    ):
        variant("two-ducts", textbook_from_seed(0))


@pytest.mark.parametrize("name", VARIANTS)
def test_tubes_lie_clear_of_each_other_at_rest(name: str) -> None:
    for seed in SEEDS:
        patient = variant(name, textbook_from_seed(seed))
        organ = build_organ(patient)
        for k, tube in enumerate(organ.tubes):
            for other in organ.tubes[:k]:
                apart = line(organ, tube)[:, None] - line(organ, other)[None]
                walls = radius_m(patient, tube) + radius_m(patient, other)
                assert np.linalg.norm(apart, axis=-1).min() > walls + 0.001


@pytest.mark.parametrize("name", CROSSING)
def test_a_crossing_artery_passes_over_or_under_the_duct_as_seen(name: str) -> None:
    for seed in SEEDS:
        organ = build_organ(variant(name, textbook_from_seed(seed)))
        duct, artery = (line(organ, tube) for tube in ("duct", "artery"))
        beside = np.linalg.norm(((duct[:, None] - artery) @ np.stack([RIGHT, UP], 1)), axis=-1)
        i, j = np.unravel_index(beside.argmin(), beside.shape)
        assert beside[i, j] < 2e-4  # they cross as the endoscope sees them
        nearer = (duct[i] - artery[j]) @ AWAY
        assert (nearer > 0) == (name == "artery-in-front")
        side = 1 if (artery[0] - duct[0]) @ RIGHT > 0 else -1
        assert side * ((artery[-1] - duct[-1]) @ RIGHT) < 0  # ends on the other side of the neck


def test_each_variant_has_the_property_in_its_name() -> None:
    for seed in SEEDS:
        patient = textbook_from_seed(seed)
        shortest, longest = TEXTBOOK["duct_length_m"]
        assert (
            needed_m("duct", applier_for(patient.duct_diameter_m))
            <= variant("short-duct", patient).duct_length_m
            < shortest
        )
        assert variant("low-insertion", patient).duct_length_m > longest
        assert variant("wide-duct", patient).duct_diameter_m > TEXTBOOK["duct_diameter_m"][1]
        assert variant("swapped", patient).structure("left") == "artery"
        assert variant("fat", patient).fat_strands > 6
        second = variant("two-arteries", patient).arteries["second artery"]
        assert second.diameter_m < patient.artery_diameter_m
        assert second.insertion_m >= patient.artery_insertion_m


def test_fat_joins_duct_artery_and_sac_and_is_drawn_until_it_breaks() -> None:
    world = World()
    world.reset(variant("fat", textbook_from_seed(10_000)))
    organ, first = world.organ, world.anatomy.remnants
    strands = organ.remnants[first:]
    ends = {
        part: np.isin(strands, rings).any(axis=1)
        for part, rings in {**organ.rings, "sac": organ.sac_rings}.items()
    }
    assert (ends["duct"] & ends["artery"]).sum() >= len(strands) // 2
    assert (ends["duct"] & ends["sac"]).any()
    assert (ends["artery"] & ends["sac"]).any()
    np.testing.assert_array_equal(holding(world), organ.remnants)
    world.tissue.host("link_stiffness")[0, 2] = 0.0
    np.testing.assert_array_equal(holding(world), np.delete(organ.remnants, 2, axis=0))
    world.tissue.add_links(0, np.array([[0, 1]]), rest_m=np.zeros(1), stiffness=1.0, strength_n=1.0)
    np.testing.assert_array_equal(holding(world), np.delete(organ.remnants, 2, axis=0))


@pytest.fixture(scope="module")
def two_arteries() -> Organ:
    return build_organ(variant("two-arteries", textbook_from_seed(10_000)))


@pytest.mark.parametrize("other", ["duct", "artery"])
def test_the_second_artery_pushes_the_other_tubes_away(two_arteries: Organ, other: str) -> None:
    tissue = tissue_of(two_arteries, None)
    second, first = two_arteries.rings["second artery"], two_arteries.rings[other]
    x = two_arteries.vertices.copy()
    to = x[first[6, 0]] - x[second[6, 0]]
    radii = tissue.host("tube_radius")[0, [two_arteries.tubes.index(other), 2]]
    x[second] += (np.linalg.norm(to) - float(radii.sum()) + 3e-4) * unit(to)
    put(tissue, x)
    f = forces(tissue, "tube contact")
    assert np.abs(f).max() > 0.01
    np.testing.assert_allclose(f.sum(axis=0), 0.0, atol=50 * EPS * np.abs(f).sum())
    assert (f[second[6]].sum(axis=0)) @ to < 0 < (f[first].sum(axis=(0, 1))) @ to


def test_environments_with_different_tubes_step_as_they_do_alone(two_arteries: Organ) -> None:
    organs = [build_organ(textbook_from_seed(10_000)), two_arteries]
    together = Tissue(organs)
    alone = [Tissue([organ]) for organ in organs]
    for tissue in (together, *alone):
        for _ in range(20):
            tissue.step()
    for b, tissue in enumerate(alone):
        np.testing.assert_array_equal(together.positions(b), tissue.positions())


def test_the_second_artery_can_be_clipped_and_cut_and_then_bleeds(two_arteries: Organ) -> None:
    tissue = Tissue([two_arteries])
    tubes = Tubes(tissue, two_arteries)
    middle = 0.5 * tubes.length_m["second artery"]
    wait = astride(tubes, "second artery", middle + 0.006, beyond_m=0.5 * POLYMER.length_m)
    clip = latch(tubes, wait, POLYMER, number=1, time_s=0.0)
    assert [c.tube for c in clip.crossings] == ["second artery"]
    T = astride(tubes, "second artery", middle, beyond_m=0.5 * BLADE_LENGTH_M)
    cuts = sever(tubes, T, time_s=0.0)
    assert [c.tube for c in cuts] == ["second artery"]
    assert tubes.in_two_parts("second artery")
    found = {leak.side: leak.rate_m3_s for leak in leaks(tubes, [], cuts)}
    assert (
        found["body"] > found["gallbladder"] > 0.0
    )  # blood that comes back from the gallbladder is less
