"""What a sentence says besides its order: politeness and that all is well; asides.toml lists it."""

from __future__ import annotations

import re
from functools import cache

from planner.language.rules.phrase_lists import phrase_lists

_POLITELY = "would you please "


def without_asides(text: str) -> str:
    """Return a text with plain politeness, and without clauses that only say that all is well."""
    begins, ends, polite = _patterns()
    return polite.sub(_POLITELY, ends.sub("", begins.sub("", text)))


@cache
def _patterns() -> tuple[re.Pattern[str], re.Pattern[str], re.Pattern[str]]:
    """Return what finds clauses of content at the beginning, at the end, and politeness."""
    lists = phrase_lists("asides")["asides"]
    well, polite = (rf"(?:{'|'.join(lists[name])})" for name in ("well", "polite"))
    patterns = (
        rf"^(?:{well}[,.;:!]+ *(?:so |and )?)+(?=\w)",
        rf"(?<=\w)(?:[,;:.]+ *(?:and |as |since |because |now )?{well})+ *[.!]*$",
        rf"(?<!\w){polite}(?: please,?)?(?!\w) *",
    )
    begins, ends, politely = (re.compile(one, re.IGNORECASE) for one in patterns)
    return begins, ends, politely
