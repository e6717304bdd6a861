"""Tests that a saved state may hold whatever the field's history may hold."""

from dataclasses import is_dataclass
from typing import get_args, get_type_hints

from tissue_sim.state_tensors import SAVED_CLASSES
from tissue_sim.surgery.record import Record


def dataclasses_in(kind, found=frozenset()):
    """Return the dataclasses that a value of this type may hold, with those in their fields."""
    if is_dataclass(kind) and kind not in found:
        found |= {kind}
        for inner in get_type_hints(kind).values():
            found = dataclasses_in(inner, found)
    for inner in get_args(kind):
        found = dataclasses_in(inner, found)
    return found


def test_a_saved_state_may_hold_all_that_a_record_may_hold():
    assert {kind.__name__ for kind in dataclasses_in(Record)} <= set(SAVED_CLASSES)
