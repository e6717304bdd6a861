"""Answer questions about observations: identity and places of tubes and clips, and the grasp."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planner.instruction import Instruction
from planner.language.rules.questions import Thing
from planner.person.premises import clips_in_words
from planner.procedure.cholecystectomy import CHOLECYSTECTOMY
from planner.procedure.procedure import Procedure
from planner.scene.duct_side import duct_side, from_neck_m, side_confidence, structure_seen, tube_of
from planner.scene.in_words import joined, way_in_words
from planner.scene.next_task import applier_on, clips_needed_on, clips_on, lying_on
from planner.scene.predicates import has_slipped, is_low, traction_n
from tissue_sim.frames import Array
from tissue_sim.patient.tube_names import TUBES, Tube
from tissue_sim.sensing.observation import MAX_CLIPS, N_LINE, Observation
from tissue_sim.sensing.polyline import nearest_on, place_on
from tissue_sim.thresholds import HELD_PINCH_N
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM
from tissue_sim.tools.instruments import INSTRUMENTS, clip_of

SURELY = 0.99  # a higher probability is reported as more than this: no model is that good
AT_RISK: tuple[Thing, ...] = ("common bile duct", "hepatic artery")


@dataclass(frozen=True, kw_only=True)
class Asked:
    """The input of an answer.

    Attributes:
        instruction: The instruction in force.
        observation: The present observation.
        procedure: The procedure under way.
        about: The thing that the question names; None if there is none.
    """

    instruction: Instruction
    observation: Observation
    procedure: Procedure = CHOLECYSTECTOMY
    about: Thing | None = None

    @property
    def tube(self) -> Tube | None:
        """Return the tube that the question names; None if it names none."""
        return tube_named(self.about, self.observation)

    @property
    def lacks(self) -> str:
        """Return in words that the named tube is not there; "" if it is, or none is named."""
        missing = self.tube is not None and self.tube not in self.observation.tubes
        return f"There is no {self.tube} tube here." if missing else ""

    @property
    def name(self) -> str:
        """Return the name of that tube's structure."""
        return structure_seen(self.tube, self.observation) if self.tube else ""


def tube_named(about: Thing | None, observation: Observation) -> Tube | None:
    """Return the tube of a thing that a sentence names; None if that is no tube."""
    if about in ("duct", "artery"):
        return tube_of(about, observation)
    return next((tube for tube in TUBES if about == f"{tube} tube"), None)


def clips(asked: Asked) -> str:
    """Return in words the number of clips on the named tube, or on each tube."""
    if asked.tube == "third":
        return f"I see {_on_tube(asked.tube, asked.observation)}."
    return f"I see {counts(asked.observation)}."


def on(asked: Asked) -> str:
    """Return in words the number of clips on the tube at hand, and the last clip's visibility."""
    tube, observation = asked.tube or asked.instruction.task.tube, asked.observation
    if tube is None:
        return f"I see {counts(observation)}."
    rows = np.flatnonzero(lying_on(tube, observation))
    last_m = observation.std_m[N_LINE + rows[-1:]]
    placed = len(last_m) and not observation.is_severed(tube)
    how = f", the last one to within {within_mm(last_m)}" if placed else ""
    return (
        f"I see {_on_tube(tube, observation)}{how}. Whether a clip would hold a pull I cannot see."
    )


def cut(asked: Asked) -> str:
    """Return in words whether the named tube is cut, or which tubes are."""
    observation = asked.observation
    if asked.tube is not None:
        is_cut = observation.is_severed(asked.tube)
        count = clips_in_words(asked.tube, observation)
        return f"The {asked.name} is cut." if is_cut else f"The {asked.name} is not cut: {count}."
    parts = [
        f"the {structure_seen(tube, observation)} is"
        f" {'cut' if observation.is_severed(tube) else 'not cut'}"
        for tube in observation.tubes
    ]
    return f"{joined(parts).capitalize()}."


def held(asked: Asked) -> str:
    """Return in words whether the grasper holds the gallbladder, by its motor currents."""
    observation = asked.observation
    force = f"its jaws press with {max(observation.pinch_n, 0.0):.1f} N"
    if observation.pinch_n < HELD_PINCH_N:
        return f"The grasper does not hold the gallbladder: {force}."
    low = ", but low, at its neck" if is_low(observation) else ""
    pull = f"{force}, and it pulls with {traction_n(observation):.1f} N"
    return f"The grasper holds the gallbladder{low}: {pull}."


def which(asked: Asked) -> str:
    """Return in words the duct's tube, the confidence, and the tube at which the robot works.

    A question that names a tube gets its size, too, and one that names the third tube the answer
    whether there is one. A question that names a tool or a clip gets the answer which tool is
    mounted.
    """
    sized = f" {_size(asked.tube, asked.observation)}" if asked.tube and not asked.lacks else ""
    if asked.tube == "third":
        return f"{_third(asked.observation)}{sized}"
    if asked.about in ("left tool", "right tool", "clip"):
        return _tool(LEFT_ARM if asked.about == "left tool" else RIGHT_ARM, asked.observation)
    works = asked.instruction.task.tube
    at_hand = f" I work on the {structure_seen(works, asked.observation)} now." if works else ""
    return f"{_side(asked.observation)}{at_hand}{sized}"


def _size(tube: Tube, observation: Observation) -> str:
    """Return in words a tube's length at rest, its width, and the clips that it takes."""
    kind, needed = clip_of(applier_on(tube, observation)), clips_needed_on(tube, observation)
    return (
        f"The {structure_seen(tube, observation)} looks {1e3 * observation.length_m(tube):.0f} mm"
        f" long and {2e3 * observation.radius_m(tube):.1f} mm wide: {needed} {kind.name} clips."
    )


def _tool(arm: int, observation: Observation) -> str:
    """Return in words the tool of an arm, and its clip."""
    tool = INSTRUMENTS[observation.tools[arm]]
    side = "left" if arm == LEFT_ARM else "right"
    if tool.clip is None:
        return f"The {side} arm holds the {tool.in_words}."
    how = "with" if observation.clip_loaded else "without"
    loaded = f"{how} a {tool.clip.name} clip" + ("" if observation.clip_loaded else " in it")
    return f"The {side} arm holds the {tool.in_words}, {loaded}."


def _third(observation: Observation) -> str:
    """Return in words whether there is a third tube, with confidence."""
    chance = observation.third_tube
    if "third" in observation.tubes:
        return f"There is a third tube here, {_sure(chance)} sure: a second artery."
    return f"There is no third tube here, {_sure(1.0 - chance)} sure."


def _sure(chance: float) -> str:
    """Return a confidence in words: "87%"."""
    return f"more than {SURELY:.0%}" if chance > SURELY else f"{chance:.0%}"


def _side(observation: Observation) -> str:
    """Return in words the duct's tube, with confidence and reason, and the third tube."""
    duct = duct_side(observation)
    near_mm, far_mm = sorted(1e3 * np.linalg.norm(from_neck_m(observation), axis=1))
    artery = "right" if duct == "left" else "left"
    third = f" {_third(observation)}" if "third" in observation.tubes else ""
    return (
        f"The duct is the {duct} tube and the artery the {artery} one,"
        f" {_sure(side_confidence(observation))} sure: their upper"
        f" ends are {near_mm:.1f} and {far_mm:.1f} mm from the gallbladder's neck.{third}"
    )


def where(asked: Asked) -> str:
    """Return in words the way from a tip to the named thing, in the endoscope's directions."""
    about, observation = asked.about, asked.observation
    if about in ("clip", "gallbladder", "left tool"):
        return _where_points(about, observation)
    lines = [_line(asked)] if about not in (None, "right tool") else _tubes(observation)
    return " ".join(_where_line(name, line, observation) for name, line in lines)


def distance(asked: Asked) -> str:
    """Return in words the right tip's distance to the named thing, or to structures at risk."""
    if asked.tube is not None:
        return _where_line(*_line(asked), asked.observation)
    tip_m = _tip_m(RIGHT_ARM, asked.observation)
    both = (asked.observation.common_bile_duct_m, asked.observation.hepatic_artery_m)
    lines = zip(AT_RISK, both, strict=True)
    far = " and ".join(f"{1e3 * nearest_on(ln, tip_m)[2]:.0f} mm from the {n}" for n, ln in lines)
    return f"The right tip is {far}, measured to their middle lines."


def counts(observation: Observation) -> str:
    """Return the clips on all tubes: "2 of 3 clips on the duct and the artery cut"."""
    return joined([_on_tube(tube, observation) for tube in observation.tubes])


def within_mm(std_m: Array) -> str:
    """Return in words the 95 % bound of the errors along an axis, of the median point (n,)."""
    return f"{2e3 * float(np.median(std_m)):.1f} mm"


def _on_tube(tube: Tube, observation: Observation) -> str:
    """Return the state of a tube in words: "2 of 3 clips on the duct"."""
    name = structure_seen(tube, observation)
    if observation.is_severed(tube):
        return f"the {name} cut"
    return (
        f"{clips_on(tube, observation)} of {clips_needed_on(tube, observation)} clips on the {name}"
    )


def _where_points(about: Thing | None, observation: Observation) -> str:
    if about == "clip":
        closed = min(observation.n_clips, MAX_CLIPS)
        return (
            _where(
                f"last of {closed} clips", observation.clips_m[closed - 1], RIGHT_ARM, observation
            )
            if (closed)
            else "I see no clip that is closed."
        )
    k, share, _ = nearest_on(observation.sac_m, _tip_m(LEFT_ARM, observation))
    holds = "" if has_slipped(observation) or about != "left tool" else " It holds the gallbladder."
    return (
        _where("gallbladder", place_on(observation.sac_m, k + share), LEFT_ARM, observation) + holds
    )


def _where_line(name: str, line: Array, observation: Observation) -> str:
    k, share, _ = nearest_on(line, _tip_m(RIGHT_ARM, observation))
    return _where(name, place_on(line, k + share), RIGHT_ARM, observation)


def _where(name: str, place_m: Array, arm: int, observation: Observation) -> str:
    way_m = place_m - _tip_m(arm, observation)
    tip = "left" if arm == LEFT_ARM else "right"
    far_mm = 1e3 * float(np.linalg.norm(way_m))
    return f"The {name} is {far_mm:.0f} mm from the {tip} tip: {way_in_words(way_m)}."


def _line(asked: Asked) -> tuple[str, Array]:
    """Return the name and the middle line of the named structure."""
    observation = asked.observation
    if asked.tube is not None:
        return asked.name, observation.tube_m(asked.tube)
    at_risk = asked.about == "hepatic artery"
    return (
        asked.about or "",
        observation.hepatic_artery_m if at_risk else observation.common_bile_duct_m,
    )


def _tubes(observation: Observation) -> list[tuple[str, Array]]:
    return [
        (structure_seen(tube, observation), observation.tube_m(tube)) for tube in observation.tubes
    ]


def _tip_m(arm: int, observation: Observation) -> Array:
    return observation.tips_endoscope[arm, :3, 3]
