"""Tests of the field's conditions: they are shares, they are saved, and dye covers its share."""

from dataclasses import replace

import numpy as np
import pytest

from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.rendering.drawn_tissue import looks
from tissue_sim.rendering.textures import colours
from tissue_sim.surgery.record import Conditions


@pytest.mark.parametrize("name", ["grip", "dyed"])
@pytest.mark.parametrize("value", [-0.01, 1.01, float("nan")])
def test_a_value_that_is_not_a_share_is_refused(name, value):
    with pytest.raises(ValueError, match=f"conditions: {name} = .* must be from 0 to 1"):
        Conditions(**{name: value})


def test_conditions_are_part_of_the_state_and_a_new_patient_is_dry_and_clean(one_world):
    one_world.reset(textbook_from_seed(3))
    one_world.conditions = Conditions(grip=0.2, dyed=0.4)
    saved = one_world.state()
    one_world.reset(textbook_from_seed(3))
    assert one_world.conditions == Conditions()
    one_world.restore(saved)
    assert one_world.conditions == Conditions(grip=0.2, dyed=0.4)


@pytest.mark.parametrize("dyed", [0.0, 0.1, 0.6, 1.0])
def test_dye_covers_its_share_of_every_part_and_leaves_the_rest(dyed):
    for look in looks(textbook_from_seed(3), dyed).values():
        clean = colours(replace(look, dyed=0.0))
        covered = (colours(look) != clean).any(axis=-1)
        assert covered.mean() == pytest.approx(dyed, abs=1e-3)


def test_more_dye_covers_everything_that_less_dye_covers():
    look = next(iter(looks(textbook_from_seed(3), 0.0).values()))
    little, much = (colours(replace(look, dyed=dyed)) != colours(look) for dyed in (0.2, 0.5))
    assert np.all(much | ~little)
