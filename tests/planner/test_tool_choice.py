"""Tests of the choice of the right tool: an applier by a tube's seen width, once for each tube."""

from dataclasses import replace

import numpy as np
import pytest

from planner.procedure.cholecystectomy import task_from_text
from planner.scene.next_task import ToolChoice, applier_on, clip_kinds, clips_needed_on
from tests.planner.observations import clipped
from tests.tissue_sim.kinds import APPLIER, POLYMER, SLIM_APPLIER, TITANIUM
from tissue_sim.outcome import nurse
from tissue_sim.outcome.clip_rule import FEWEST_CLIPS, USUAL_CLIPS, needed_m
from tissue_sim.sensing.observation import Observation

CLIP, SECOND = (task_from_text(f"clipping {nth} clip left tube") for nth in ("first", "third"))
OTHER = task_from_text("clipping first clip right tube")
CUT, BACK = (
    task_from_text("go to the cutting position left tube"),
    task_from_text("going back first clip left tube"),
)


def seen(left_mm: float, right_mm: float = 2.0, tool: str = "clip_applier") -> Observation:
    """Return an observation of tubes of these diameters."""
    radii_m = 0.5e-3 * np.array([left_mm, right_mm])
    return replace(clipped(), tube_radius_m=radii_m, tools=("grasper", tool))


@pytest.mark.parametrize(
    ("wide_mm", "tool"),
    [(1.9, SLIM_APPLIER), (3.5, SLIM_APPLIER), (4.0, SLIM_APPLIER), (4.2, APPLIER), (9.0, APPLIER)],
)
def test_a_clip_comes_by_the_applier_of_the_tubes_width(wide_mm, tool):
    assert ToolChoice().tool(CLIP, seen(wide_mm)) == tool.name


def test_a_tubes_applier_is_chosen_once_whatever_the_noise_of_its_width():
    choice, rng = ToolChoice(), np.random.default_rng(0)
    first = choice.tool(CLIP, seen(3.99))
    tools = {choice.tool(task, seen(4.0 + rng.normal(0.0, 0.3))) for task in (CLIP, SECOND) * 20}
    assert tools == {first} == {SLIM_APPLIER.name}
    assert choice.tool(OTHER, seen(3.0, right_mm=4.5)) == APPLIER.name


@pytest.mark.parametrize("mounted", [SLIM_APPLIER.name, APPLIER.name])
def test_a_retraction_keeps_whichever_applier_is_mounted(mounted):
    now = seen(5.0, tool=mounted)
    assert ToolChoice().tool(BACK, now) == mounted
    assert not nurse.is_needed(now, mounted, clip=False)


def test_a_cut_takes_the_scissors():
    assert ToolChoice().tool(CUT, seen(2.0)) == "scissors"
    assert ToolChoice().tool(BACK, seen(2.0, tool="scissors")) == "clip_applier"


@pytest.mark.parametrize(
    ("tool", "loaded", "needed"),
    [
        (APPLIER.name, True, True),
        (SLIM_APPLIER.name, True, False),
        (SLIM_APPLIER.name, False, True),
    ],
)
def test_the_nurse_changes_a_loaded_applier_of_the_other_kind(tool, loaded, needed):
    now = replace(seen(2.0, tool=tool), clip_loaded=loaded)
    assert nurse.is_needed(now, ToolChoice().tool(CLIP, now), clip=True) == needed


def test_the_clip_that_sits_on_a_tube_says_which_kind_the_tube_takes():
    """A width that is seen otherwise later does not change how many clips the tube needs."""
    along_m = 0.5 * (needed_m("duct", SLIM_APPLIER) + needed_m("duct", APPLIER))
    now = replace(clipped(left=1), tube_radius_m=np.full(2, 0.0021))  # wider than 4 mm
    now = replace(now, rest_length_m=np.full(2, along_m))
    for kind, n in ((TITANIUM, USUAL_CLIPS), (POLYMER, FEWEST_CLIPS)):
        told = replace(now, clip_kinds=(kind.name,))
        assert applier_on("left", told).clip is kind
        assert clips_needed_on("left", told) == n
    assert clip_kinds("left", now) == [POLYMER]  # unknown: taken for the tube's own
