"""Tests of telling the duct from the artery: on patients with either of them on the left."""

import pytest

from planner.scene.duct_side import duct_side, structure_seen, tube_of
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.patient.variants import VARIANTS, variant
from tissue_sim.world import World

SEED = 10_004


@pytest.mark.parametrize("name", ["textbook", "swapped", "artery-in-front", "low-insertion"])
def test_the_duct_is_found_from_what_is_observed(name: str) -> None:
    assert name in VARIANTS
    anatomy = variant(name, textbook_from_seed(SEED))
    seen = World().reset(anatomy)
    assert anatomy.structure(duct_side(seen)) == "duct"
    for tube in ("left", "right"):
        assert structure_seen(tube, seen) == anatomy.structure(tube)
        assert tube_of(structure_seen(tube, seen), seen) == tube
