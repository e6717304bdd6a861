"""The words surgeons use, each with the slot that it fills; phrases before their parts."""

from __future__ import annotations

from typing import NamedTuple


class Sense(NamedTuple):
    """A slot and its value; slot "filler" says nothing, as please does not."""

    slot: str
    value: str


_HANDS = ("arm", "hand", "instrument", "tool", "one", "manipulator")
_GRIPPERS = ("gripper", "grippers", "jaw", "jaws", "fingers", "tips")
_BY_SENSE: dict[Sense, str] = {
    # whose motion
    Sense("arm", "left"): "grasper, graspers, forceps, prograsp, holding arm, grasping arm",
    Sense("arm", "right"): (
        "clip applier, applier, clipper, clip applicator, clipping arm, scissors, shears, scissor"
    ),
    Sense("arm", "both"): "both, both arms, both hands, both instruments, both sides, all",
    Sense("jaw_word", "jaw"): ", ".join(_GRIPPERS),
    # where to
    Sense("direction", "left"): "left, leftwards, leftward, to the left, to my left",
    Sense("direction", "right"): "right, rightwards, rightward, to the right, to my right",
    Sense("direction", "higher"): (
        "higher, up, upwards, upward, raise, lift, elevate, above, rise, superior, high"
    ),
    Sense("direction", "lower"): (
        "lower, down, downwards, downward, drop, dip, below, sink, descend, inferior, low"
    ),
    Sense("direction", "away"): (
        "away, away from me, away from the camera, deeper, deep, further in, farther in, in, inwards,"
        " forward, forwards, advance, push in, further, farther, far"
    ),
    Sense("direction", "towards"): (
        "towards, towards me, toward, toward me, towards the camera, to me, closer to me, out, outwards,"
        " pull back, pull out, back towards me, back toward me, shallower, shallow, nearer, closer"
    ),
    # jaws
    Sense("jaw", "open"): "open, opened, widen, spread, release, unclench, opening, wide",
    Sense("jaw", "close"): "close, shut, squeeze, clench, pinch, closed, closing, tighten, narrow",
    # what is done
    Sense(
        "deed", "clip"
    ): "clip, clipping, clamp, clamping, ligate, ligating, occlude, apply, place",
    Sense("deed", "cut"): (
        "cut, cutting, divide, dividing, transect, transecting, snip, sever, severing, dissect through"
    ),
    Sense("deed", "cut_position"): (
        "go to the cutting position, cutting position, cut position, into position to cut,"
        " position to cut, position for cutting, ready to cut, where to cut"
    ),
    Sense(
        "deed", "grab"
    ): "grab, grabbing, grasp, grasping, hold, take, catch, pick up, get hold of",
    Sense("deed", "back"): (
        "go back, going back, back off, back, retreat, withdraw, retract, return, pull away, move back,"
        " come back, get out, come away"
    ),
    Sense("from_cut", "yes"): "from the cut, after the cut, from cutting, after cutting, from cut",
    # to what
    Sense("tube", "left"): "left tube, left one's tube, tube on the left, left vessel, left duct",
    Sense("tube", "right"): "right tube, tube on the right, right vessel",
    Sense("structure", "duct"): "duct, cystic duct, bile duct",
    Sense("structure", "artery"): "artery, cystic artery",
    Sense("organ", "gallbladder"): "gallbladder, gall bladder, gb, infundibulum, neck, fundus",
    Sense("ordinal", "1"): "first, 1st, number one, number 1, clip one, clip 1, one, 1",
    Sense("ordinal", "2"): "second, 2nd, number two, number 2, clip two, clip 2, two, 2",
    Sense("ordinal", "3"): (
        "third, 3rd, number three, number 3, clip three, clip 3, three, 3, last, final"
    ),
    # about the run
    Sense("word", "stop"): "stop, halt, freeze, abort, emergency stop, stop moving, stay still",
    Sense("word", "pause"): "pause, wait, hang on, hold on, one moment, one second, a moment",
    Sense("word", "resume"): "resume, continue, carry on, go on, proceed, keep going, unpause",
    Sense("word", "repeat"): "repeat, again, once more, do that again, same again, one more time",
    Sense("word", "undo"): "undo, revert, take that back, reverse that, undo last",
    Sense("word", "next step"): "next step, next, next task, move on, on to the next",
    Sense("word", "let go"): "let go, let it go, let go of it, release it",
    # how it is said
    Sense("too", "yes"): "too, overly",
    Sense("not", "yes"): "don't, dont, do not, never, not, no",
    Sense("filler", ""): (
        "please, could you, can you, would you, will you, now, just, a bit, a little, a touch, slightly,"
        " a tad, bit, little, touch, tad, the, a, an, your, my, of, with, to, on, at, it, that, is, are,"
        " you, you're, youre, i, i'd, would, like, want, need, let's, lets, us, and, then, ok, okay, so,"
        " move, moving, bring, put, take, shift, nudge, go, get, come, bring, some, more, mm,"
        " millimetre, millimetres, millimeter, millimeters, cm, by, for, me, this, these, those, hey,"
        " robot, doctor, thanks, thank you, very, quite, gently, slowly, carefully, again please,"
        " from, tip, ahead, give, have, here, there, will, be, should, still, time, side, position"
    ),
}
_SIDED = {
    f"{side} {thing}": Sense("arm", side)
    for side in ("left", "right")
    for thing in (*_HANDS, "grasper", "side instrument", "forceps", "hand instrument")
} | {
    f"{side} {thing}": Sense("gripper", side)
    for side in ("left", "right", "both")
    for thing in _GRIPPERS
}
LEXICON: dict[str, Sense] = {
    phrase.strip(): sense for sense, phrases in _BY_SENSE.items() for phrase in phrases.split(",")
} | _SIDED
LONGEST = max(len(phrase.split()) for phrase in LEXICON)
