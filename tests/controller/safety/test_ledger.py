"""Tests of the ledger: one entry an event, whatever happens within it."""

from controller.safety.ledger import APART_S, Entry, Ledger

KEPT_OFF, SLOWED = "keep-out: scissors kept off the liver", "tip speed: right tip"
STEP_S = 1 / 30


def ledger(*altered):
    """Return the ledger after alterations (time_s, limits)."""
    found = Ledger()
    for time_s, *limits in altered:
        found.note(
            Entry(time_s=time_s, limits=tuple(limits), margin=time_s, nearest_m=1.0 - time_s)
        )
    return found


def test_alterations_for_the_same_reason_are_one_entry_with_a_beginning_and_an_end():
    (entry,) = ledger(*((k * STEP_S, KEPT_OFF) for k in range(10))).entries
    assert (entry.time_s, entry.until_s, entry.commands) == (0.0, 9 * STEP_S, 10)
    assert entry.margin == 9 * STEP_S
    assert entry.nearest_m == 1.0 - 9 * STEP_S


def test_a_pause_begins_another_entry():
    assert len(ledger((0.0, SLOWED), (0.9 * APART_S, SLOWED)).entries) == 1
    assert len(ledger((0.0, SLOWED), (1.1 * APART_S, SLOWED)).entries) == 2


def test_reasons_that_take_turns_are_two_entries_and_one_that_joins_is_part_of_it():
    turns = ledger(*((k * STEP_S, (SLOWED, KEPT_OFF)[k % 2]) for k in range(6)))
    assert [entry.limits for entry in turns.entries] == [(SLOWED,), (KEPT_OFF,)]
    (joined,) = ledger((0.0, SLOWED), (STEP_S, SLOWED, KEPT_OFF)).entries
    assert joined.limits == (SLOWED, KEPT_OFF)


def test_what_a_person_allowed_stands_apart():
    found = Ledger()
    found.note(Entry(time_s=0.0, limits=(SLOWED,)))
    found.note(Entry(time_s=STEP_S, limits=(SLOWED,), overridden=("a lock",)))
    assert len(found.entries) == 2


def test_an_entry_reads_as_a_surgeon_would_say_it():
    entry = Entry(time_s=0.0, limits=(KEPT_OFF,), nearest_m=0.0012)
    assert entry.words == "scissors kept off the liver, 1.2 mm"
    entry = Entry(time_s=0.0, limits=("tissue force: grasper kept from pinching harder",))
    assert entry.words == "grasper kept from pinching harder"
