"""Which clip is meant, said at length: "third and last one", "a clip, that'll be the second"."""

from __future__ import annotations

import re

_NTH = r"(first|second|third|1st|2nd|3rd)"
_RULES = (
    (r"\b(?:hem|haem)-?o-?loks?\b|\b(?:liga|hemo|haemo|endo)-?clips?\b", "clip"),
    (rf"\b{_NTH},? and (?:last|final)(?: one| clip)?\b,?", r"\1 clip"),
    (rf"\b{_NTH} of (?:the |its |your |those )?(?:three )?clips?\b", r"\1 clip"),
    (rf"\ba clip\b(.*?),? (?:and )?(?:that(?:'ll| will|'d)? be|that(?:'s| is)|it'?ll be|making it)"
     rf" (?:the |number )?{_NTH}(?: one| clip)?(?=$|[.!])", r"\2 clip\1"),
    (rf"\b{_NTH} (duct|artery) clip\b", r"\1 clip on \2"),
    (r"\b(duct|artery) clip (?:number |no\.? )?(one|two|three|1|2|3)\b(?! ?(?:mm|mil|cm|cent))",
     r"clip \2 on \1"),
)  # fmt: skip


def with_plain_ordinals(text: str) -> str:
    """Return a text in which a clip's number stands before it."""
    for pattern, instead in _RULES:
        text = re.sub(pattern, instead, text, flags=re.IGNORECASE)
    return text
