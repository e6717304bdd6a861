"""Tests of the fuzzer that stays: nothing tampered with hurts, and what would hurt is counted."""

import time

import numpy as np
import pytest

from scenarios.bench.trials.file_faults import FILES
from scenarios.bench.trials.tampering import Target, flipped, restructured, tried
from tests.slow import slow


@pytest.mark.parametrize("name", [slow(k) if k == "evaluation" else k for k in FILES])
def test_no_tampered_file_hurts(name, tmp_path):
    tally = tried(FILES[name](tmp_path), inputs=40, seed=1)
    assert tally.is_good, tally
    assert sum(tally.ended.values()) == 40
    assert tally.ended["refused"] > 20


def test_what_hurts_is_counted_and_shown(monkeypatch):
    monkeypatch.setattr("scenarios.bench.trials.tampering.HANG_S", 0.2)

    def one(read, is_changed=lambda read: True):
        target = Target(tamper=lambda chance: None, read=read, is_changed=is_changed)
        (how,) = tried(target, inputs=1, seed=0).ended
        return how

    def broken():
        raise KeyError("config")

    def refusing():
        raise ValueError("it is damaged")

    def refusing_at_length():
        raise ValueError("two\nlines")

    assert one(lambda: None) == "changed"
    assert one(lambda: None, lambda read: False) == "harmless"
    assert one(broken) == "traceback"
    assert one(refusing) == "refused"
    assert one(refusing_at_length) == "traceback"
    assert one(lambda: time.sleep(1)) == "hang"


def test_an_edit_of_a_seed_is_always_the_same_and_leaves_the_good_one():
    good, tree = bytes(range(200)), {"a": [1, {"b": 2}], "c": None}
    for k in range(50):
        edits = [
            (flipped(good, chance), restructured(tree, chance))
            for chance in (np.random.default_rng(k), np.random.default_rng(k))
        ]
        assert edits[0] == edits[1]
    assert tree == {"a": [1, {"b": 2}], "c": None}
