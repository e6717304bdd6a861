"""Sentences with several commands: their parts, each with what it leaves unsaid."""

from __future__ import annotations

import re

_JOINTS = re.compile(
    r"\s*(?:;"
    r"|[,.]? (?:and )?(?:then|than|followed by|after that|afterwards|next|finally|subsequently)"
    r"(?: you)?\b,?"
    r"|, and\b|\band\b(?! (?:a )?(?:half|quarter))|,(?!\d)"
    r"|\bbefore\b(?: you)?|\bwhile\b|&|\bplus\b)\s*"
)
_LEADS = re.compile(
    r"^(?:first(?:ly)?,? (?!clip|one|tube|duct|artery)|(?:after|once) you(?:'ve| have))\s*"
)
_LATER = re.compile(r"^before (?:you )?([^,]+), (.+)$")  # "before cutting the duct, go up"
_IN_ORDER = re.compile(
    r"\b(?:then|than|followed by|after that|afterwards|subsequently|before|once you|after you)\b|;"
)
_ARM = re.compile(
    r"\b(left|right)(?: (?:arm|hand|gripper|grasper|jaws?|instrument|tool|one))?\b"
    r"|\b(grasper|forceps)\b|\b(clip applier|applier|clipper|scissors|shears)\b|\bboth\b"
)
_ASIDE = re.compile(r"\b(?:to|towards?|on|further|more) (?:the |your )?(?:left|right)\b")
_IT = re.compile(
    r"\b(?:it|that arm|that one|them|this one|the same (?:arm|one)"
    r"|that (?:gripper|hand|instrument))\b"
)
_DIRECTED = re.compile(
    r"\b(up|down|higher|lower|deeper|in|out|left|right|leftwards?|rightwards?|towards? me|away"
    r"|closer|forward|back|raise|lift|drop|open|close|shut|pull|push|move|nudge|upwards?"
    r"|downwards?|shallower)\b"
)
_BOTH = re.compile(
    r"\b(?:both|the two) (?:of the |of your )?(?:arms|hands|instruments|tools|of them)\b"
)
_SIDE_AND_SIZE = re.compile(r"(?:the )?(?:left|right)(?: one)?(?: by)? \S+ ?\w+")  # which way?
_JAWS = re.compile(r"\b(open|close|shut|widen|squeeze)\b")
_TUBE = re.compile(r"\b(?:(?:left|right) (?:tube|structure|vessel)|(?:cystic )?(?:duct|artery))\b")
_DEED = re.compile(r"\b(?:clip|cut|clamp|divide|snip|transect|back)\b")
_AGAIN = re.compile(r"\s+(?:again|too|as well|please)$")
_BARE = re.compile(r"(?<![\d.#])(\d+(?:[.,]\d+)?)\s*$")


def in_order(text: str) -> bool:
    """Return whether a sentence says that one thing comes after another."""
    return bool(_IN_ORDER.search(text.lower()))


def names_an_act(part: str) -> bool:
    """Return whether a part of a sentence names a direction, the jaws, a clip or a cut."""
    return bool(_DIRECTED.search(part) or _DEED.search(part))


def parts_of(text: str) -> list[str]:
    """Return the parts of an English sentence, each a sentence of its own; one if it has no joint.

    A part that names no arm, or "it", is about the arm before; a deed without a tube about the one
    that is named next to it; a direction of both arms about one after the other.
    """
    plain = _LATER.sub(r"\2, then \1", text.lower().strip())
    plain = _LEADS.sub("", plain)
    parts = [part for part in _JOINTS.split(plain) if part.strip()]
    if any(map(_SIDE_AND_SIZE.fullmatch, parts)) and _BOTH.search(plain):
        return [text]
    parts = [one for part in parts for one in _of_each_arm(part)]
    if len(parts) < 2:
        return [text]
    tubes = {found[0] for part in parts if (found := _TUBE.search(part))}
    arm, whole = "", list[str]()
    for part in parts:
        named = _arm(part)
        whole.append(_completed(_AGAIN.sub("", part), "" if named else arm, named, tubes))
        arm = named or arm
    return whole


def _completed(part: str, arm_before: str, named: str, tubes: set[str]) -> str:
    """Return a part with the arm before, the only tube, or the unit that it leaves unsaid."""
    of_tube = _TUBE.search(part)
    if arm_before and not of_tube:
        part = _about(arm_before, part)
    if _DEED.search(part) and not of_tube and not named and len(tubes) == 1:
        part = f"{part} {min(tubes)}"
    return _BARE.sub(r"\1 mm", part) if _DIRECTED.search(part) else part


def _of_each_arm(part: str) -> list[str]:
    if _BOTH.search(part) and not _JAWS.search(part):
        return [_BOTH.sub(f"{side} arm", part) for side in ("left", "right")]
    return [part]


def _arm(part: str) -> str:
    """Return the arm that a part names, as "left" or "right"; "to the left" names none."""
    found = _ARM.search(_ASIDE.sub("", part))
    if not found or found[0] == "both":
        return ""
    sided = found[1] or ("left" if found[2] else "right")
    return sided if found[2] or found[3] or " " in found[0] else ""


def _about(arm: str, part: str) -> str:
    name = f"{arm} gripper" if _JAWS.search(part) else f"{arm} arm"
    if _IT.search(part):
        return _IT.sub(name, part, count=1)
    if _JAWS.search(part):
        return f"{part} {name}"
    return f"{name} {part}" if _DIRECTED.search(part) else part
