"""Find which clip or structure is meant where it is said at length, or with its side.

Examples are "third and last one", several clips one by one, "the left duct", "with a titanium
clip", and after a cut "then retreat". A side must agree with what is seen.
"""

from __future__ import annotations

import re

from planner.command import COMMANDS
from planner.language.reading import Applier, Said
from planner.language.rules.phrase_search import patterns, rewritten, rules_in
from planner.procedure.cholecystectomy import CHOLECYSTECTOMY
from tissue_sim.patient.tube_names import Tube

_RE = patterns("references")


def clip_by_clip(text: str) -> str:
    """Return a lower-case text in which each of several clips has its own part."""
    if not (found := _RE["clips"].search(text)):
        return text
    before, *clips, after = (group for group in found.groups() if group is not None)
    each = (f"{before}clip {number}{after}" for number in clips)
    return ", then ".join(each) + text[found.end() :]


def with_plain_ordinals(text: str) -> str:
    """Return a text in which a clip's number stands before it."""
    return rewritten(text, rules_in("references", "with_plain_ordinals", re.IGNORECASE))


def without_side(text: str) -> tuple[str, Tube | None]:
    """Return a text with the side of a structure taken out, and that side."""
    for pattern in (_RE["sided"], _RE["on_side"]):
        if found := pattern.search(text.lower()):
            side: Tube = "left" if found["side"] == "left" else "right"
            return pattern.sub(r"\g<what>", text.lower(), count=1), side
    return text, None


def way_back(part: str, before: Said | None) -> Said | None:
    """Return the command to go back that follows a clip or a cut: "then retreat"."""
    cut = before and before.command.deed == "cut"
    if before and cut and _RE["retreat"].search(part):
        return Said(command=COMMANDS[f"go back from the {before.command.text}"])
    task = before and before.command.task
    if not task or task.goes_back or task.tube is None or not _RE["retreat"].search(part):
        return None
    back = CHOLECYSTECTOMY.after(task).text
    if before and before.command.structure:
        back = back.replace("left tube", before.command.structure)
    return Said(command=COMMANDS[back])


def applier_in(text: str) -> tuple[Applier, str] | None:
    """Return the applier that a sentence asks for, and the rest of it; None if it asks for none."""
    words = text.lower().strip().rstrip(".!")
    for name in ("ordered", "named_alone", "bare", "with_it", "put_on", "added"):
        if found := _RE[name].search(words):
            rest = f"{words[: found.start()]}{'a ' * (name == 'put_on')}{words[found.end() :]}"
            return _applier(found["kind"]), _RE["joint"].sub("", rest)
    return None


def _applier(kind: str) -> Applier:
    if kind == "other":
        return "other"
    return "large" if _RE["large"].fullmatch(kind) else "slim"
