"""Sentences with several commands: their parts, each with what it leaves unsaid."""

from __future__ import annotations

import re

from planner.language.rules.pairs import arm_by_arm
from planner.language.rules.phrase_search import patterns, rewritten, rules_in
from planner.language.rules.references import clip_by_clip
from planner.language.rules.sizes import echo_in, without_size

_RE = patterns("compound")


def in_order(text: str) -> bool:
    """Return whether a sentence says that one thing comes after another."""
    return bool(_RE["in_order"].search(text.lower()))


def names_an_act(part: str) -> bool:
    """Return whether a part of a sentence names a direction, the jaws, a clip or a cut."""
    return bool(_RE["directed"].search(part) or _RE["deed"].search(part))


def parts_of(text: str) -> list[str]:
    """Return the parts of an English sentence, each a sentence of its own; one if it has no joint.

    A part that names no arm, or "it", is about the arm before. A deed without a tube is about the
    one that is named next to it. A direction of both arms is about one after the other.
    """
    plain = _RE["later"].sub(r"\2, then \1", text.lower().strip().rstrip(".!"))
    plain = _RE["asides"].sub("", plain)
    plain = arm_by_arm(_RE["leads"].sub("", clip_by_clip(_without_marks(plain))))
    parts = _with_its_arm([part for part in _RE["joints"].split(plain) if part.strip()])
    parts, leader = _without_leader(parts)
    if any(map(_RE["side_and_size"].fullmatch, parts)) and _RE["both"].search(plain):
        return [text]
    parts = [one for part in parts for one in _of_each_arm(part)]
    if len(parts) < 2:
        return [text]
    tubes = {found[0] for part in parts if (found := _RE["tube"].search(part))}
    arm, deed, tube, whole = "", "", min(tubes) if len(tubes) == 1 else "", list[str]()
    for part in map(_plain_part, parts):
        if "gallbladder" in plain:
            part = _RE["gripped"].sub(r"\1 gallbladder", part)
        if deed and _RE["tube_alone"].fullmatch(part):
            part = f"{deed} {part}"
        named = arm_named(part)
        whole.append(_completed(_RE["again"].sub("", part), "" if named else arm, named, tube))
        arm = named or arm
        deed, tube = _found(_RE["clip_or_cut"], part) or deed, _found(_RE["tube"], part) or tube
    return sorted(whole, key=lambda part: _names(leader, part), reverse=True) if leader else whole


def _without_leader(parts: list[str]) -> tuple[list[str], str]:
    """Return the parts without a last one such as "the artery first", and what it names."""
    last = _RE["first_one"].fullmatch(parts[-1].strip()) if parts else None
    if not last:
        return parts, ""
    tubes = ("duct", "artery") if last[1] in ("duct", "artery") else ("left tube", "right tube")
    each = ([_RE["both_tubes"].sub(tube, part) for tube in tubes] for part in parts[:-1])
    return [one for both in each for one in dict.fromkeys(both)], last[1]


def _names(leader: str, part: str) -> bool:
    return bool(re.search(rf"(?<!to the )\b{leader}\b", part))


def _without_marks(text: str) -> str:
    """Return a numbered list, "1) ... 2) ...", with semicolons in place of its marks."""
    marks = "".join(_RE["mark"].findall(text))
    counts = len(marks) > 1 and any(run.startswith(marks) for run in ("123456", "abcdef"))
    return _RE["mark"].sub("; ", text) if counts and _RE["mark"].match(text) else text


def _plain_part(part: str) -> str:
    """Return a part without its first word of joining, in which "the left" alone is an arm."""
    part = rewritten(_RE["part_leads"].sub("", part), rules_in("compound", "does"))
    if (echo := echo_in(part)) and _RE["side_alone"].fullmatch(echo.text):
        return _RE["side_alone"].sub(r"\1 arm", part, count=1)
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
        elif before and _RE["arm_alone"].fullmatch(part) and not arm_named(before):
            joined[-1] = f"{part} {before}"
        else:
            joined.append(part)
    return joined


def _belongs_to(part: str, before: str) -> bool:
    """Return whether a part is a length, a tube or "clip it" alone, which the part before lacks."""
    length = without_size(part)
    if length.size_m is not None and not length.text:
        return without_size(before).size_m is None
    if _RE["tube_alone"].fullmatch(part):
        return not _RE["tube"].search(before)
    return bool(_RE["same_clip"].fullmatch(part)) and "clip" in before


def _completed(part: str, arm_before: str, named: str, tube: str) -> str:
    """Return a part with the arm or the tube before, or the unit, that it leaves unsaid."""
    of_tube = _RE["tube"].search(part)
    if arm_before and not of_tube:
        part = _about(arm_before, part)
    if tube and _RE["deed"].search(part) and not of_tube and not named:
        part = f"{part} {tube}"
    return _RE["bare"].sub(r"\g<0> mm", part) if _RE["directed"].search(part) else part


def _of_each_arm(part: str) -> list[str]:
    if _RE["both"].search(part) and not _RE["jaws"].search(part):
        return [_RE["both"].sub(f"{side} arm", part) for side in ("left", "right")]
    return [part]


def arm_named(part: str) -> str:
    """Return the arm that a part names, as "left" or "right"; "to the left" names none."""
    found = _RE["arm"].search(_RE["aside"].sub("", part))
    if not found or found[0] == "both":
        return ""
    sided = found[1] or ("left" if found[2] else "right")
    return sided if found[2] or found[3] or " " in found[0] else ""


def _about(arm: str, part: str) -> str:
    name = f"{arm} gripper" if _RE["jaws"].search(part) else f"{arm} arm"
    if _RE["it"].search(part):
        return _RE["it"].sub(name, part, count=1)
    if _RE["jaws"].search(part):
        return f"{part} {name}"
    return f"{name} {part}" if _RE["directed"].search(part) else part
