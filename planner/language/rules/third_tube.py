"""Give the third tube one name, however it is said: "second artery", "accessory vessel".

The number of an artery and that of a clip are the same words. So the name is taken out of a text
before any clip is counted: "second clip on the second artery".
"""

from __future__ import annotations

import re

from planner.language.rules.phrase_search import patterns, rewritten, rules_in

THIRD_TUBE = "thirdtube"  # one word, so that no rule reads a clip's number in it


def with_third_tube(text: str) -> str:
    """Return a text in which every name of the third tube is `THIRD_TUBE`."""
    if patterns("third_tube")["other_count"].search(text):
        return text
    return rewritten(text, rules_in("third_tube", "names", re.IGNORECASE))


def with_artery(text: str) -> str:
    """Return a text with the artery in place of the third tube, for what knows two tubes only.

    What a sentence does with a tube does not depend on the tube.
    """
    return text.replace(THIRD_TUBE, "artery")
