"""Tests of the counts of what rules change."""

import pytest

from planner.rules.rule_use import ANY, RuleCounts, RuleUse, rule_uses_of, total


def counts(*changed: float) -> tuple[RuleUse, ...]:
    """Return the use of a rule that moved a tip by so much in each decision; zero: not at all."""
    rules = RuleCounts("controller", ["centre", "other"])
    for moved_m in changed:
        rules.note("centre", changed=moved_m > 0.0, moved_m=moved_m or None)
    *uses, any_rule = rules.uses()
    assert any_rule.rule == ANY
    return tuple(uses)


def test_decisions_and_changes_are_counted_with_the_largest_change():
    centre, other = counts(0.001, 0.0, 0.003, 0.0)
    assert (centre.decisions, centre.changed, centre.share) == (4, 2, 0.5)
    assert centre.most_m == pytest.approx(0.003)
    assert (other.decisions, other.changed, other.share, other.most_m) == (0, 0, 0.0, None)


def test_the_uses_of_episodes_add_up():
    (centre, other) = total([*counts(0.001, 0.0), *counts(0.004)])
    assert (centre.decisions, centre.changed, centre.most_m) == (3, 2, 0.004)
    assert (other.decisions, other.changed) == (0, 0)
    assert centre.most_rad is None


def test_a_policy_without_rules_has_no_uses():
    assert rule_uses_of(object(), None) == ()
