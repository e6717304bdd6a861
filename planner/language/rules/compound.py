"""Sentences with several commands: their parts, each with what it leaves unsaid."""

from __future__ import annotations

import re

from planner.language.rules.pairs import arm_by_arm
from planner.language.rules.references import clip_by_clip
from planner.language.rules.sizes import echo_in, without_size

_JOINTS = re.compile(
    r"\s*(?:;"
    r"|[,.]? ?(?:and )after,"
    r"|[,.]? ?(?:and,? )?\b(?:then|than|followed by(?: (?:the|a))?|afterwards?"
    r"|(?:after|following|straight after) (?:that|this|which|it(?= the))|thereafter|later"
    r"|next(?! (?:step|clip|task|move|one))"
    r"|finally|lastly|secondly|thirdly|subsequently|having done (?:so|that|this)"
    r"|(?:once|when|as soon as|after) (?:there|done"
    r"|(?:that|this|it)(?:'s| is| has been)(?: all)? (?:done|finished|complete|over|through)"
    r"|you(?:'ve| have)(?: done| finished)?(?: with)? (?:so|that|this|it|done|finished)"
    r"|you(?:'re| are) (?:done|finished|through|there)(?: with (?:that|this|it))?)"
    r"|while you're (?:there|at it))"
    r"(?: you)?\b,?"
    r"|, and\b|\b(?<!ahead )and\b(?! (?:a )?(?:half|quarter))|,(?!\d)"
    r"|\bbefore\b(?: you)?|\bwhile\b|&|\bplus\b|\. (?:step \w+:)?|\bstep \w+:)\s*"
)
_LEADS = re.compile(
    r"^(?:(?:please|kindly|(?:would|could|can|will) you),? )*"
    r"(?:first(?:ly)?,? (?!clip|one|tube|duct|artery)"
    r"|(?:after|once|when|as soon as) you(?:'ve| have)(?: just)?)\s*"
)
_PART_LEADS = re.compile(
    r"^(?:queue|instead|now|also|proceed to|go ahead and|just"
    r"|(?:second|third|fourth)(?=,? the (?:left|right) (?:arm|hand|gripper)\b)"
    r"|as (?:a|the) (?:first|second|third|next|last|final)(?: (?:step|thing|one))?"
    r"|(?:start|begin|kick|lead|finish|end|conclude|wrap)(?: off| up)? (?:with|by)),? "
)
_DOES = {  # "once you have gone back, ..."
    "gone": "go", "opened": "open", "closed": "close", "clipped": "clip", "moved": "move",
    "grabbed": "grab", "backed": "back", "raised": "raise", "lowered": "lower", "lifted": "lift",
    "placed": "place", "put": "put", "cut": "cut", "divided": "divide", "snipped": "snip",
    "applied": "apply", "fired": "fire", "grasped": "grasp", "shut": "close", "released": "release",
    "let": "let", "pulled": "pull", "pushed": "push", "nudged": "nudge", "shifted": "move",
    "dropped": "drop", "brought": "bring", "taken": "take", "come": "come", "retreated": "retreat",
    "withdrawn": "withdraw", "transected": "transect", "severed": "sever", "advanced": "advance",
}  # fmt: skip
_DONE = re.compile(rf"^({'|'.join(_DOES)})\b")
_ASIDES = re.compile(
    r"^(?:sequence|in order|in this order|two things|three things|plan):\s*"
    r"|,? in (?:that|this) (?:order|sequence)$|,? (?:one after (?:the other|another)|in turn)$"
    r"|,? both(?: of them)? please(?=,|$)"
    r"|, (?:if you (?:would|please|could|don't mind)|please|would you|will you|kindly)(?=,|$)"
)
_FIRST_ONE = re.compile(
    r"(?:but )?(?:the )?(?:cystic )?(left|right|duct|artery|grasper|scissors|applier)"
    r"(?: \w+)? first"
)
_BOTH_TUBES = re.compile(r"\bboth (?:of the |the )?(?:tubes|structures|vessels|of them)\b")
_MARK = re.compile(r"(?:^|(?<=\s))\(?([1-6a-f])[.)]:?\s+")
# "before cutting the duct, go up"
_LATER = re.compile(r"^(?:before|prior to|ahead of)(?: you)? ([^,]+), (.+)$")
_IN_ORDER = re.compile(
    r"\b(?:then|than|followed by|after (?:that|this|it)|afterwards|subsequently|thereafter|before"
    r"|(?:once|after|when|as soon as) you|prior to"
    r"|(?:start|begin|finish|end)(?: off| up)? (?:with|by))\b"
    r"|;|, [^,]+ (?:after|later)$"
)
_ARM = re.compile(
    r"\b(left|right)(?: (?:arm|hand|gripper|grasper|jaws?|instrument|tool|one))?\b"
    r"|\b(grasper|forceps)\b|\b(clip applier|applier|clipper|scissors|shears)\b|\bboth\b"
)
_ARM_ALONE = re.compile(r"(?:(?:with|for) )?(?:the |your )?(?:left|right|both) (?:arms?|hands?)")
_GRIPPED = re.compile(r"\b(grab|grasp|take|seize|catch|release|let go of) (?:it|that)(?: again)?$")
_SAME_CLIP = re.compile(
    r"(?:please |go ahead and )?(?:clip|do|apply|place|put|fire) (?:it|that)(?: on)?"
    r"(?: please| now)?"
)
_SIDE_ALONE = re.compile(r"(?:the )?\b(left|right)\b(?: one)?")
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
_DEED = re.compile(
    r"\b(?:clip|cut|clamp|divide|snip|transect|back|cutting position|position to cut"
    r"|(?:place|put|throw|apply|add) (?:on )?(?:the |a )?"
    r"(?:first|second|third|next|last|another)|(?:first|second|third|next|last) one)\b"
)
_CLIP_OR_CUT = re.compile(r"\b(?:clip|cut|clamp|divide|snip|transect)\b")
_TUBE_ALONE = re.compile(rf"(?:the )?(?:{_TUBE.pattern})")
_AGAIN = re.compile(r"\s+(?:again|too|as well|please)$")
_BARE = re.compile(
    r"(?<![\d.#])(\d+(?:[.,]\d+)?)(?:\s*$|(?= (?:up|down|higher|lower|deeper|to the|towards)\b))"
    r"|(?<=\bby )(one|two|three|four|five|six|seven|eight|ten)$"
)


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
    plain = _LATER.sub(r"\2, then \1", text.lower().strip().rstrip(".!"))
    plain = _ASIDES.sub("", plain)
    plain = arm_by_arm(_LEADS.sub("", clip_by_clip(_without_marks(plain))))
    parts = _with_its_arm([part for part in _JOINTS.split(plain) if part.strip()])
    parts, leader = _without_leader(parts)
    if any(map(_SIDE_AND_SIZE.fullmatch, parts)) and _BOTH.search(plain):
        return [text]
    parts = [one for part in parts for one in _of_each_arm(part)]
    if len(parts) < 2:
        return [text]
    tubes = {found[0] for part in parts if (found := _TUBE.search(part))}
    arm, deed, tube, whole = "", "", min(tubes) if len(tubes) == 1 else "", list[str]()
    for part in map(_plain_part, parts):
        if "gallbladder" in plain:
            part = _GRIPPED.sub(r"\1 gallbladder", part)
        if deed and _TUBE_ALONE.fullmatch(part):
            part = f"{deed} {part}"
        named = arm_named(part)
        whole.append(_completed(_AGAIN.sub("", part), "" if named else arm, named, tube))
        arm = named or arm
        deed, tube = _found(_CLIP_OR_CUT, part) or deed, _found(_TUBE, part) or tube
    return sorted(whole, key=lambda part: _names(leader, part), reverse=True) if leader else whole


def _without_leader(parts: list[str]) -> tuple[list[str], str]:
    """Return the parts without a last one such as "the artery first", and what it names."""
    last = _FIRST_ONE.fullmatch(parts[-1].strip()) if parts else None
    if not last:
        return parts, ""
    tubes = ("duct", "artery") if last[1] in ("duct", "artery") else ("left tube", "right tube")
    each = ([_BOTH_TUBES.sub(tube, part) for tube in tubes] for part in parts[:-1])
    return [one for both in each for one in dict.fromkeys(both)], last[1]


def _names(leader: str, part: str) -> bool:
    return bool(re.search(rf"(?<!to the )\b{leader}\b", part))


def _without_marks(text: str) -> str:
    """Return a numbered list, "1) ... 2) ...", with semicolons in place of its marks."""
    marks = "".join(_MARK.findall(text))
    counts = len(marks) > 1 and any(run.startswith(marks) for run in ("123456", "abcdef"))
    return _MARK.sub("; ", text) if counts and _MARK.match(text) else text


def _plain_part(part: str) -> str:
    """Return a part without its first word of joining, in which "the left" alone is an arm."""
    part = _DONE.sub(lambda said: _DOES[said[1]], _PART_LEADS.sub("", part))
    if (echo := echo_in(part)) and _SIDE_ALONE.fullmatch(echo.text):
        return _SIDE_ALONE.sub(r"\1 arm", part, count=1)
    return part


def _found(pattern: re.Pattern[str], part: str) -> str:
    found = pattern.search(part)
    return found[0] if found else ""


def _with_its_arm(parts: list[str]) -> list[str]:
    """Join a part that is an arm or a length alone to the one before: "up, 2 mm, right arm"."""
    joined = list[str]()
    for part in parts:
        before = joined[-1] if joined else ""
        if before and _belongs_to(part, before):
            joined[-1] = f"{before} {part}"
        elif before and _ARM_ALONE.fullmatch(part) and not arm_named(before):
            joined[-1] = f"{part} {before}"
        else:
            joined.append(part)
    return joined


def _belongs_to(part: str, before: str) -> bool:
    """Return whether a part is a length, a tube or "clip it" alone, which the part before lacks."""
    length = without_size(part)
    if length.size_m is not None and not length.text:
        return without_size(before).size_m is None
    if _TUBE_ALONE.fullmatch(part):
        return not _TUBE.search(before)
    return bool(_SAME_CLIP.fullmatch(part)) and "clip" in before


def _completed(part: str, arm_before: str, named: str, tube: str) -> str:
    """Return a part with the arm or the tube before, or the unit, that it leaves unsaid."""
    of_tube = _TUBE.search(part)
    if arm_before and not of_tube:
        part = _about(arm_before, part)
    if tube and _DEED.search(part) and not of_tube and not named:
        part = f"{part} {tube}"
    return _BARE.sub(r"\g<0> mm", part) if _DIRECTED.search(part) else part


def _of_each_arm(part: str) -> list[str]:
    if _BOTH.search(part) and not _JAWS.search(part):
        return [_BOTH.sub(f"{side} arm", part) for side in ("left", "right")]
    return [part]


def arm_named(part: str) -> str:
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
