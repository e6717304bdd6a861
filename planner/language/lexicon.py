"""The words surgeons use, each with the slot that it fills; a phrase goes before its parts."""

from __future__ import annotations

from typing import NamedTuple


class Sense(NamedTuple):
    """What a phrase says.

    Attributes:
        slot: kind, arm, tube, organ or what: a slot of a command; "side": a side of whatever the
            rest is about, or a direction; "which": a side, no direction; "alone": a kind when
            nothing else is said; "too", "from_cut", "is": see the grammar; "refusal": not to be
            done, with the reason; "filler": says nothing, as please does not.
        value: Of the slot.
    """

    slot: str
    value: str


FILLER = Sense("filler", "")
_BY_SENSE: dict[Sense, str] = {
    Sense("arm", "left"): "grasper, graspers, forceps, prograsp, holding arm, grasping arm",
    Sense("arm", "right"): (
        "clip applier, applier, clipper, clip applicator, applicator, clipping arm, scissors,"
        " scissor, shears, cutting arm"
    ),
    Sense("arm", "both"): (
        "both, both arms, both hands, both instruments, both tools, both sides, both of them,"
        " grippers, hands"
    ),
    Sense("what", "left"): (
        "to the left, to left, to my left, leftwards, leftward, far left, further left,"
        " farther left, more left, too left, toward the left, towards the left"
    ),
    Sense("what", "right"): (
        "to the right, to right, to my right, rightwards, rightward, far right, further right,"
        " farther right, more right, too right, toward the right, towards the right"
    ),
    Sense("what", "higher"): (
        "higher, up, upwards, upward, raise, raising, lift, lifting, elevate, elevating, rise, high,"
        " hire, upper"
    ),
    Sense("what", "lower"): (
        "lower, lowering, down, downwards, downward, drop, dropping, dip, sink, descend, low"
    ),
    Sense("what", "away"): (
        "away, away from me, away from us, away from the camera, away from camera, deeper, deep,"
        " in, inwards, inward, forward, forwards, advance, advancing, into the depth,"
        " farther from me, further from me"
    ),
    Sense("what", "towards"): (
        "towards, towards me, toward, toward me, towards us, towards the camera, toward the camera,"
        " to me, to the camera, to camera, out, outwards, outward, shallower, shallow, nearer, near,"
        " closer, close to me, close to the camera, close to camera, backwards, backward"
    ),
    Sense("kind", "open"): (
        "open, opening, open up, too closed, widen, spread, spreading, unclench, wide, wider, wide open,"
        " loosen"
    ),
    Sense("kind", "close"): (
        "close, shut, squeeze, clench, pinch, closing, shutting, tighten, tight, tighter,"
        " narrow, too open"
    ),
    Sense("kind", "clip"): (
        "clip, clipping, clamp, clamping, ligate, ligating, occlude, secure, next clip,"
        " another clip, one more clip, clip again"
    ),
    Sense("kind", "cut"): (
        "cut, cutting, divide, dividing, transect, transecting, snip, snipping, sever, severing,"
        " cut through"
    ),
    Sense("kind", "cut_position"): (
        "cutting position, cut position, position to cut, position for cutting, for cutting,"
        " for the cut, cutting place, cutting point, cutting site, where you cut, where to cut,"
        " get ready to cut, prepare to cut, line up, line up to cut, in position to cut,"
        " into position to cut, take up the cutting position"
    ),
    Sense("kind", "grab"): (
        "grab, grabbing, grasp, grasping, seize, catch, catch hold of, pick up, hold, holding,"
        " get hold of, take hold of, grab hold of, take the gallbladder, take gallbladder, grip,"
        " get a grip on, take a grip on"
    ),
    Sense("kind", "go_back"): (
        "go back, going back, back, back off, back out, back away, retreat, withdraw, withdrawing,"
        " retract, retracting, return, returning, pull away, pull back, move back, move away from,"
        " come back, get back, come away, go away from, step back, leave, come back after, go back after, return after, retreat after,"
        " move back after, back off after, withdraw after, get back after"
    ),
    Sense("from_cut", "yes"): (
        "from the cut, after the cut, from cutting, after cutting, from cut, after cut,"
        " from the cutting position, after you cut"
    ),
    Sense("what", "duct"): "duct, cystic duct, dukt, duck",
    Sense("what", "artery"): "artery, cystic artery",
    Sense("organ", "gallbladder"): (
        "gallbladder, gall bladder, gb, infundibulum, fundus, gallbladder neck, gall bladder neck,"
        " neck of the gallbladder, tissue"
    ),
    Sense("what", "1"): (
        "first clip, 1st clip, clip number one, clip number 1, clip one, clip 1, clip first,"
        " clip no 1"
    ),
    Sense("what", "2"): (
        "second clip, 2nd clip, clip number two, clip number 2, clip two, clip 2, clip second,"
        " clip no 2"
    ),
    Sense("what", "3"): (
        "third clip, 3rd clip, clip number three, clip number 3, clip three, clip 3, clip third,"
        " last clip, final clip, clip no 3"
    ),
    Sense("kind", "stop"): (
        "stop, halt, freeze, abort, emergency stop, stop moving, stay still, hold still, cease"
    ),
    Sense("kind", "pause"): (
        "pause, wait, hang on, hold on, one moment, one second, just a moment, just a second,"
        " give me a second, give me a moment, give me a minute, wait a second, wait a moment,"
        " wait a minute, hold on a second, hold on a moment, hang on a second, stand by,"
        " take a break, hold it"
    ),
    Sense("kind", "resume"): (
        "resume, continue, carry on, go on, keep going, unpause, you can continue,"
        " continue with the procedure, continue the procedure, continue with the operation,"
        " continue the operation"
    ),
    Sense("alone", "resume"): "go ahead, proceed",
    Sense("kind", "repeat"): (
        "repeat, repeat that, same again, repeat the last command, repeat the last one,"
        " repeat the last step, repeat the last move"
    ),
    Sense("alone", "repeat"): (
        "again, once again, once more, do that again, do it again, do the same again, try again,"
        " one more time, another time"
    ),
    Sense("kind", "undo"): (
        "undo, undo last, undo the last, revert, take that back, take it back, reverse, scratch,"
        " undo the last command, undo the last step, undo the last move"
    ),
    Sense("kind", "next step"): (
        "next step, next task, move on, move along, proceed to the next step, on to the next step,"
        " move on to the next step, on to the next one, on to the next task, go on to the next step, continue with the next step,"
        " go on with the next step, carry on with the next step"
    ),
    Sense("alone", "next step"): "next, next one",
    Sense("kind", "let go"): "let go, let it go, let go of, release, releasing, drop it, let loose",
    Sense("too", "yes"): "too, overly",
    Sense("is", "yes"): "is, are, it's, you're, youre, that's, its",
    FILLER: (
        "please, kindly, could you, can you, would you, will you, would you mind, now, just, a bit,"
        " a little, a touch, slightly, a tad, bit, little, touch, tad, notch, some, somewhat, more,"
        " a little bit, little bit, bit more, half, amount, small, smidge, hair, fraction, few,"
        " couple, even, still, only, much, far, further, farther, enough, very, quite, mm,"
        " millimetre, millimetres, millimeter, millimeters, cm, centimetre, centimeter,"
        " one millimetre, two millimetres, one millimeter, two millimeters,"
        " the, a, an, your, of, with, to, on, onto, at, it, that, by, for, from, this, these, those,"
        " in the, you, i want, i want you to, i'd like, i would like, i need, we need, i'd like"
        " you to, i would like you to, i need you to, need, needs, let's, lets, let us, and, then,"
        " ok, okay, so, well, ah, oh, uh, um, er, erm, hm, hmm, move, moving, bring, bringing, put,"
        " putting, take, taking, shift, shifting, nudge, nudging, slide, swing, ease, inch, pull,"
        " pulling, push, pushing, tip, tilt over, reach, go, going, get, come, coming, make, set,"
        " adjust, give, use, using, place, placing, apply, applying, fire, place for, do,"
        " should be, should go, should come, should move, has to, have to, must, position, start,"
        " begin, go ahead and, go ahead with, first of all, hey, robot, calot, doctor, thanks,"
        " thank you, gently, slowly, carefully, quickly, right now, right there, right here,"
        " right away, straight away, immediately, here, there, off, over, across, through, gap,"
        " cystic, structure, structures, vessel, vessels, tube, tubes, arm, arms, hand, instrument,"
        " instruments, tool, tools, manipulator, gripper, jaw, jaws, finger, fingers, everything,"
        " all, last one, last command, last move, last step, goes, up the grip"
    ),
    Sense("refusal", "it says what not to do"): (
        "don't, dont, do not, never, not, no, without, avoid, cannot, can't, won't, isn't, aren't,"
        " shouldn't, mustn't, nothing, neither, nor, instead, rather, except, instead of, nope,"
        " didn't, doesn't, wasn't, hasn't, haven't, stop clipping, refrain, forbidden, forget"
    ),
    Sense("refusal", "it sets a condition or a time"): (
        "if, when, whenever, unless, until, till, before, after, once, while, as soon as, later,"
        " tomorrow, soon, yet, provided, in case, should, would, could, might, may, maybe, perhaps,"
        " tonight, today, yesterday, minutes, seconds, hours, imagine, suppose, pretend, assume,"
        " assuming, whether, because, since, almost, nearly, about to, next time"
    ),
    Sense("refusal", "it tells how things are"): (
        "was, were, has, have, had, been, being, looks, look, looked, looking, seems, seemed, did,"
        " done, i, i'm, i've, i'll, we, we're, we've, he, she, they, he's, she's, they're, said,"
        " says, say, saying, told, tell, nice, nicely, good, great, perfect, perfectly, fine, well"
        " done, closed, opened, bad, badly, beautiful, already, just now, moved, opened up, cuts, clips, clipped,"
        " grabbed, grabs, raised, lifted, lowered, dropped, pulled, pushed, moves, opens, closes,"
        " released, stopped, stops, went, slipped, think, thought, believe, know, remember, am,"
        " will, myself, himself, surgeon, resident, nurse, patient, assistant, student, hurts"
    ),
    Sense("refusal", "it is about something else than clips, cuts and the two arms"): (
        "camera, scope, endoscope, laparoscope, lens, monitor, screen, video, picture, image, light,"
        " lights, lamp, zoom, focus, irrigate, irrigation, rinse, wash, suction, suck, aspirate,"
        " cautery, cauterize, cauterise, coagulate, coagulation, burn, bleed, bleeds, bleeding,"
        " bleeder, blood, dissect, dissection, peel, strip, scrape, sweep, suture, stitch, sew, tie,"
        " knot, staple, stapler, needle, hook, drain, drape, sponge, gauze, bag, trocar, port,"
        " insufflate, inflate, deflate, gas, abdomen, liver, stomach, bowel, colon, duodenum,"
        " intestine, pancreas, spleen, kidney, heart, lung, lungs, vein, aorta, portal, hepatic,"
        " common, bile, peritoneum, omentum, fat, skin, nerve, remove, removing, extract, insert,"
        " inject, rotate, turn, twist, tilt, spin, roll, swap, switch, change, exchange, replace,"
        " load, reload, pass, table, bed, head, foot, leg, pressure, pulse, oxygen, music, radio,"
        " phone, call, door, window, show, see, check, inspect, count, measure, explain, save,"
        " report, file, hello, hi, morning, evening, name, joke, weather, lunch, coffee, medication,"
        " anaesthetist, anesthetist, anesthesiologist, hernia, appendix, tumour, tumor, mesh, wire,"
        " power, volume, speed, faster, slower, degrees, button, pedal, finger"
    ),
    Sense("refusal", "it is not in English"): (
        "el, la, le, les, los, las, un, una, une, der, die, das, den, dem, il, lo, por, favor, bitte,"
        " links, rechts, izquierda, derecha, izquierdo, derecho, gauche, droite, brazo, bras, und,"
        " y, et, con, avec, mit, de, du, des, hacia, nach, oben, unten, haut, bas, arriba, abajo,"
        " sinistra, destra, braccio, su, giu, per, favore, svp, esquerda, direita"
    ),
}
_ARM_NOUNS = (
    "arm", "hand", "instrument", "tool", "manipulator", "gripper", "grippers", "jaw", "jaws",
    "fingers", "grasper", "forceps", "side instrument", "hand instrument", "claw",
)  # fmt: skip
_TUBE_NOUNS = ("tube", "vessel", "structure", "tubular structure", "pipe")
_BEFORE = ("", "the ", "on ", "on the ", "to the ", "onto the ", "at the ", "of the ", "from the ")
_SIDES = ("left", "right")


def _sided() -> dict[str, Sense]:
    """Sides of arms, tubes, or either; "to the left arm" is no direction."""
    arms = {
        f"{before}{side} {noun}": Sense("arm", side)
        for before in _BEFORE
        for side in _SIDES
        for noun in _ARM_NOUNS
    }
    tubes = {
        f"{before}{side} {noun}": Sense("tube", side)
        for before in _BEFORE
        for side in _SIDES
        for noun in _TUBE_NOUNS
    }
    arms |= {f"write {noun}": Sense("arm", "right") for noun in _ARM_NOUNS}  # as heard
    either = {
        f"{before}{side}{noun}": Sense("which", side)
        for before in _BEFORE
        for side in _SIDES
        for noun in (" one", " side")
    }
    on = {f"{on}{side}": Sense("which", side) for on in ("on the ", "on ") for side in _SIDES}
    both = {f"both {noun}": Sense("arm", "both") for noun in _ARM_NOUNS}
    return arms | tubes | either | on | both | {side: Sense("side", side) for side in _SIDES}


LEXICON: dict[str, Sense] = {
    phrase.strip(): sense for sense, phrases in _BY_SENSE.items() for phrase in phrases.split(",")
} | _sided()
LONGEST = max(len(phrase.split()) for phrase in LEXICON)
