"""Split an order to both arms into one order for each arm.

The arms may go apart, together, or each its own way. A sentence may also name a direction by the
other arm: the grasper's side is to the applier's left.
"""

from __future__ import annotations

import re

from planner.language.rules.sizes import without_size

_ARMS = r"(?:(?:the|your|both|two) )*(?:arms|hands|instruments|tools)"
_ONE_ARMS = re.compile(_ARMS)
_APART = re.compile(
    rf"\b(?:spread|part|separate)\b(?: {_ARMS})\b|{_ARMS} (?:further |farther |wider )?apart\b"
)
_TOGETHER = re.compile(
    rf"\b(?:squeeze|bring|push|move|get|put) {_ARMS} (?:closer )?together\b"
    rf"|{_ARMS} (?:closer to|nearer to|towards?) (?:each other|one another)\b"
)
_GRASPER = r"(?:the )?(?:grasper|forceps|left(?: (?:arm|hand|one))?)"
_OTHER = r"(?:the )?(?:scissors|shears|(?:clip )?applier|clipper|right(?: (?:arm|hand|one))?)"
_BOTH_NAMED = re.compile(
    rf"\b(?:both )?(?:{_GRASPER} and {_OTHER}|{_OTHER} and {_GRASPER})(?= (?:arms?|hands?)\b)"
    rf"(?: (?:arms?|hands?))?|\bboth (?:{_GRASPER} and {_OTHER}|{_OTHER} and {_GRASPER})\b"
)
_EVERYTHING = re.compile(r"\beverything\b(?=.*\b(?:left|right|up|down|higher|lower|in|out|me)\b)")
_BOTH_ARMS = re.compile(r",? ?\bboth (?:arms|hands|instruments|tools)\b")
_EACH = re.compile(r",? each(?: (?:way|direction|time|one))?$")
_LENGTH_WORDS = range(1, 6)  # of "by two and a half millimetres"
_OWN_SIZES = re.compile(
    rf"^(.*{_ARMS}.*?),? (left|right)(?: (?:one|arm|hand))? (?:by )?(.+?)(?:,| and|, and)"
    r" (?:the )?(left|right)(?: (?:one|arm|hand))? (?:by )?(.+)$"
)
_THE_SIDE = re.compile(
    r"(?<!to )(?<!towards )(?<!on )\bthe (left|right)"
    r"(?= (?:slightly|a (?:bit|little|lot|touch)|while|by|comes?|goes|up|down|and|\d)|,|$)"
)
_LAST = re.compile(r"^(.+?)(?:, and|,| and) (.+?),? (?:after|later)$")
_SWAPPED = re.compile(
    r"^(.+?),? but (?:first|before(?:hand| that| you do)|(?:prior to|ahead of) (?:that|it)),? (.+)$"
)
_VERB = (
    r"(?:move|raise|lower|lift|drop|open|close|cut|clip|go|back|pull|push|nudge|come|take|bring"
    r"|place|put|fire|apply|retreat|withdraw|retract|grab|grasp|let|release|divide|snip|shut|shift)"
)
_AFTER = re.compile(
    r"^(?:after|once you're done)"
    r" ((?:clipp|cutt|clos|open|grabb|mov|rais|lower|lift)ing\b[^,]*?),? "
    rf"(?=(?:please )?{_VERB}\b)(.+)$"
)

_FIRST = re.compile(
    r"^(.*\b(?:clip|cut|clamp|divide) (?:the )?(?:cystic )?(?:duct|artery)) first,? and (?:then )?"
    r"(?:afterwards?|later|after that) (.+)$"
)
_DONE = (
    r"(?:put|placed|applied|open|clos|cut|divid|clipp|rais|lower|lift|mov|grabb|grasp|let|releas)"
)
_ONLY_AFTER = re.compile(
    r"^(?!.*\b(?:back|retreat|withdraw|retract|leave)\b)(.+?),? (?:but )?(?:only )?"
    rf"(?:(?:after|once|when|as soon as) (?:you've|you have) (?={_DONE})"
    rf"|(?:right |straight |directly |immediately )?after"
    rf" (?=(?:{_DONE}|plac|apply|putt|clipp)\w*ing))(.+)$"
)
_BEFORE_DOING = re.compile(
    r"^(?:before|prior to|ahead of) ((?:clipp|cutt|divid|clos|open|grabb|mov|rais|lower|lift)ing"
    rf"\b.+?) (?=(?:please )?{_VERB}\b)(.+)$"
)
_BEFORE_TO = re.compile(r"^before (?:to|that you|you) ([^,]+?),? (?:please |first |you )+(.+)$")
_SIDED = r"(?:left|right) (?:arm|hand|gripper|grasper|jaws?|instrument)"
_SECOND_ARM = re.compile(  # "left gripper open right gripper closed"
    rf"\b({_SIDED} [^,;]*\b(?:open(?:ed)?|closed?|shut|up|down|higher|lower|deeper|left|right|me|mm"
    rf"|millimet\w+|cm|bit|little)) (?={_SIDED} \w)"
)
_IN_ORDER = (
    (_SWAPPED, r"\2, then \1"),
    (_AFTER, r"\1, then \2"),
    (_FIRST, r"\1, then \2"),
    (_BEFORE_TO, r"\2, then \1"),
    (_ONLY_AFTER, r"\2, then \1"),
    (_BEFORE_DOING, r"\2, then \1"),
    (_SECOND_ARM, r"\1, "),
    (_LAST, r"\1, then \2"),
)


def arm_by_arm(text: str) -> str:
    """Return a lower-case sentence in which each arm has its own part, in the order of doing."""
    for pattern, instead in _IN_ORDER:
        text = pattern.sub(instead, text)
    text = _with_arms_named(text)
    return _each_by_its_own(text) or _all_by_the_same(text)


def _with_arms_named(text: str) -> str:
    """Return a text in which "the left ... the right", "grasper and scissors" are named as arms."""
    if len(set(_THE_SIDE.findall(text))) == len(("left", "right")):
        text = _THE_SIDE.sub(r"\1 arm", text)
    text = _BOTH_NAMED.sub("both arms", text)
    if _EVERYTHING.search(text):
        text = "both arms " + _EVERYTHING.sub("", _BOTH_ARMS.sub("", text)).strip()
    return text


def _each_by_its_own(text: str) -> str:
    """Write out "both arms down, left by 1 mm, right by 3 mm"; return "" for any other text."""
    found = _OWN_SIZES.match(text)
    way, one, size, other, other_size = found.groups() if found else ("",) * 5
    if one == other or not (without_size(size).size_m and without_size(other_size).size_m):
        return ""
    parts = ((one, size), (other, other_size))
    return ", then ".join(f"{_ONE_ARMS.sub(f'{side} arm', way, 1)} by {m}" for side, m in parts)


def _all_by_the_same(text: str) -> str:
    """Write out "arms apart", and give each part the length that is said for "each"."""
    text, size = _without_each(text)
    for pattern, ways in ((_APART, ("left", "right")), (_TOGETHER, ("right", "left"))):
        if pattern.search(text):
            size = size or _size_in(text)
            return f"left arm to the {ways[0]}{size}, then right arm to the {ways[1]}{size}"
    return re.sub(r",? and |, ", lambda joint: f"{size}{joint[0]}", text) + size


def _without_each(text: str) -> tuple[str, str]:
    """Return a text without "by 2 mm each", and that length; "" if it does not end so."""
    found = _EACH.search(text)
    words = text[: found.start()].split() if found else []
    for n in _LENGTH_WORDS:
        length = without_size(" ".join(words[-n:])) if len(words) > n else None
        if length and length.size_m and not length.text.strip(", "):
            return " ".join(words[:-n]).rstrip(","), f" by {' '.join(words[-n:])}"
    return text, ""


def _size_in(text: str) -> str:
    size_m = without_size(text).size_m
    return "" if size_m is None else f" by {1e3 * size_m:g} mm"


# Directions by the other arm

_ONE = (
    r"one(?! ?(?:and|point|half|quarter|mms?|mil|cms?|cent|inch|in\b))"  # no "left one millimetre"
)
_THINGS = rf"(?:arm|hand|gripper|instrument|tool|{_ONE})"
_SIDE = "(?:'s)?(?: side)?"
_LEFT = rf"(?:grasper|left {_THINGS}|holding (?:arm|hand)|forceps){_SIDE}"
_RIGHT = rf"(?:clip applier|applier|clipper|scissors|shears|right {_THINGS}){_SIDE}"
_TO = (
    r"(?:over |more |a bit |slightly )*(?:towards?|nearer(?: to)?|closer(?: to)?"
    r"|in the direction of|to) (?:the |your )?"
)
_FROM = r"(?:away from|further from|farther from|off) (?:the |your )?"
_RULES = (
    (rf"({_RIGHT}\b.*?)\b{_TO}{_LEFT}\b", r"\1 to the left"),
    (rf"({_LEFT}\b.*?)\b{_TO}{_RIGHT}\b", r"\1 to the right"),
    (rf"({_RIGHT}\b.*?)\b{_FROM}{_LEFT}\b", r"\1 to the right"),
    (rf"({_LEFT}\b.*?)\b{_FROM}{_RIGHT}\b", r"\1 to the left"),
)


def without_other_arm(text: str) -> str:
    """Return a text with a direction in place of the other arm as its goal."""
    for pattern, instead in _RULES:
        replaced, n = re.subn(pattern, instead, text.lower(), count=1)
        if n:
            return replaced
    return text
