"""Answer questions about observations: identity and places of tubes and clips, and the grasp."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planner.command import TUBES
from planner.instruction import Instruction
from planner.language.rules.questions import Thing
from planner.person.premises import clips_in_words
from planner.procedure.cholecystectomy import CHOLECYSTECTOMY
from planner.procedure.procedure import Procedure
from planner.procedure.task import Tube
from planner.scene.duct_side import duct_side, from_neck_m, side_confidence, structure_seen, tube_of
from planner.scene.in_words import way_in_words
from planner.scene.next_task import clips_needed_on, clips_on, lying_on
from planner.scene.predicates import has_slipped, is_low, traction_n
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import MAX_CLIPS, N_LINE, Observation
from tissue_sim.sensing.polyline import nearest_on, place_on
from tissue_sim.thresholds import HELD_PINCH_N
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM

SURELY = 0.99  # a higher probability is reported as more than this: no model is that good
AT_RISK: tuple[Thing, ...] = ("common bile duct", "hepatic artery")


@dataclass(frozen=True, kw_only=True)
class Asked:
    """The input of an answer.

    Attributes:
        instruction: The instruction in force.
        seen: The present observation.
        procedure: The procedure under way.
        about: The thing that the question names; None if there is none.
    """

    instruction: Instruction
    seen: Observation
    procedure: Procedure = CHOLECYSTECTOMY
    about: Thing | None = None

    @property
    def tube(self) -> Tube | None:
        """Return the tube that the question names; None if it names none."""
        if self.about in ("left tube", "right tube"):
            return "left" if self.about == "left tube" else "right"
        return tube_of(self.about, self.seen) if self.about in ("duct", "artery") else None

    @property
    def name(self) -> str:
        """Return the name of that tube's structure."""
        return structure_seen(self.tube, self.seen) if self.tube else ""


def clips(asked: Asked) -> str:
    """Return in words the number of clips on each tube."""
    return f"I see {counts(asked.seen)}."


def on(asked: Asked) -> str:
    """Return in words the number of clips on the tube at hand, and the last clip's visibility."""
    tube, seen = asked.tube or asked.instruction.task.tube, asked.seen
    if tube is None:
        return f"I see {counts(seen)}."
    rows = np.flatnonzero(lying_on(tube, seen))
    last_m = seen.std_m[N_LINE + rows[-1:]]
    placed = len(last_m) and not seen.severed[TUBES.index(tube)]
    how = f", the last one to within {within_mm(last_m)}" if placed else ""
    return f"I see {_on_tube(tube, seen)}{how}. Whether a clip would hold a pull I cannot see."


def cut(asked: Asked) -> str:
    """Return in words whether the named tube is cut, or which of both tubes is."""
    seen = asked.seen
    if asked.tube is not None:
        is_cut = seen.severed[TUBES.index(asked.tube)]
        count = clips_in_words(asked.tube, seen)
        return f"The {asked.name} is cut." if is_cut else f"The {asked.name} is not cut: {count}."
    parts = (
        f"the {structure_seen(tube, seen)} is {'cut' if severed else 'not cut'}"
        for tube, severed in zip(TUBES, seen.severed, strict=True)
    )
    return f"{' and '.join(parts).capitalize()}."


def held(asked: Asked) -> str:
    """Return in words whether the grasper holds the gallbladder, by its motor currents."""
    seen = asked.seen
    force = f"its jaws press with {max(seen.pinch_n, 0.0):.1f} N"
    if seen.pinch_n < HELD_PINCH_N:
        return f"The grasper does not hold the gallbladder: {force}."
    low = ", but low, at its neck" if is_low(seen) else ""
    pull = f"{force}, and it pulls with {traction_n(seen):.1f} N"
    return f"The grasper holds the gallbladder{low}: {pull}."


def which(asked: Asked) -> str:
    """Return in words the duct's tube, the confidence, and the tube at which the robot works."""
    works = asked.instruction.task.tube
    at_hand = f" I work on the {structure_seen(works, asked.seen)} now." if works else ""
    return f"{_side(asked.seen)}{at_hand}"


def _side(seen: Observation) -> str:
    """Return in words the duct's tube, with confidence and reason."""
    duct = duct_side(seen)
    near_mm, far_mm = sorted(1e3 * np.linalg.norm(from_neck_m(seen), axis=1))
    chance = side_confidence(seen)
    sure = f"more than {SURELY:.0%}" if chance > SURELY else f"{chance:.0%}"
    artery = "right" if duct == "left" else "left"
    return (
        f"The duct is the {duct} tube and the artery the {artery} one, {sure} sure: their upper"
        f" ends are {near_mm:.1f} and {far_mm:.1f} mm from the gallbladder's neck."
    )


def where(asked: Asked) -> str:
    """Return in words the way from a tip to the named thing, in the endoscope's directions."""
    about, seen = asked.about, asked.seen
    if about in ("clip", "gallbladder", "left tool"):
        return _where_points(about, seen)
    lines = [_line(asked)] if about not in (None, "right tool") else _tubes(seen)
    return " ".join(_where_line(name, line, seen) for name, line in lines)


def distance(asked: Asked) -> str:
    """Return in words the right tip's distance to the named thing, or to structures at risk."""
    if asked.tube is not None:
        return _where_line(*_line(asked), asked.seen)
    tip_m = _tip_m(RIGHT_ARM, asked.seen)
    both = (asked.seen.common_bile_duct_m, asked.seen.hepatic_artery_m)
    lines = zip(AT_RISK, both, strict=True)
    far = " and ".join(f"{1e3 * nearest_on(ln, tip_m)[2]:.0f} mm from the {n}" for n, ln in lines)
    return f"The right tip is {far}, measured to their middle lines."


def counts(seen: Observation) -> str:
    """Return the clips on both tubes: "2 of 3 clips on the duct and the artery cut"."""
    return " and ".join(_on_tube(tube, seen) for tube in TUBES)


def within_mm(std_m: Array) -> str:
    """Return in words the 95 % bound of the errors along an axis, of the median point (n,)."""
    return f"{2e3 * float(np.median(std_m)):.1f} mm"


def _on_tube(tube: Tube, seen: Observation) -> str:
    """Return the state of a tube in words: "2 of 3 clips on the duct"."""
    name = structure_seen(tube, seen)
    if seen.severed[TUBES.index(tube)]:
        return f"the {name} cut"
    return f"{clips_on(tube, seen)} of {clips_needed_on(tube, seen)} clips on the {name}"


def _where_points(about: Thing | None, seen: Observation) -> str:
    if about == "clip":
        closed = min(seen.n_clips, MAX_CLIPS)
        return (
            _where(f"last of {closed} clips", seen.clips_m[closed - 1], RIGHT_ARM, seen)
            if (closed)
            else "I see no clip that is closed."
        )
    k, share, _ = nearest_on(seen.sac_m, _tip_m(LEFT_ARM, seen))
    holds = "" if has_slipped(seen) or about != "left tool" else " It holds the gallbladder."
    return _where("gallbladder", place_on(seen.sac_m, k + share), LEFT_ARM, seen) + holds


def _where_line(name: str, line: Array, seen: Observation) -> str:
    k, share, _ = nearest_on(line, _tip_m(RIGHT_ARM, seen))
    return _where(name, place_on(line, k + share), RIGHT_ARM, seen)


def _where(name: str, place_m: Array, arm: int, seen: Observation) -> str:
    way_m = place_m - _tip_m(arm, seen)
    tip = "left" if arm == LEFT_ARM else "right"
    far_mm = 1e3 * float(np.linalg.norm(way_m))
    return f"The {name} is {far_mm:.0f} mm from the {tip} tip: {way_in_words(way_m)}."


def _line(asked: Asked) -> tuple[str, Array]:
    """Return the name and the middle line of the named structure."""
    seen = asked.seen
    if asked.tube is not None:
        return asked.name, seen.tube_m(asked.tube)
    at_risk = asked.about == "hepatic artery"
    return asked.about or "", seen.hepatic_artery_m if at_risk else seen.common_bile_duct_m


def _tubes(seen: Observation) -> list[tuple[str, Array]]:
    lines = (seen.left_tube_m, seen.right_tube_m)
    return [(structure_seen(tube, seen), line) for tube, line in zip(TUBES, lines, strict=True)]


def _tip_m(arm: int, seen: Observation) -> Array:
    return seen.tips_endoscope[arm, :3, 3]
