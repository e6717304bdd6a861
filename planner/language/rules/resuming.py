"""Does a sentence only let the robot go on by itself? "False alarm, carry on"; resuming.toml."""

from __future__ import annotations

import re
from functools import cache

from planner.language.rules.phrase_search import in_plain_letters, longest_first, phrase_lists

_CLAUSE = re.compile(r"[,;.!:()…,。!;—–]|\s-\s|\b(?:so|and|und|et|y|e)\b")


def resumes(text: str) -> bool:
    """Return whether each clause of a text says to go on, or that all is well, and one the first.

    Anything else in it, an act, a denial, a question, is no such word.
    """
    if text.rstrip().endswith("?"):
        return False
    clauses = list(filter(None, map(in_plain_letters, _CLAUSE.split(text))))
    go_on, calm = _patterns()
    goes = [go_on.fullmatch(one) is not None for one in clauses]
    calms = (calm.fullmatch(one) for one in clauses)
    own = any(goes) and all(a or b for a, b in zip(goes, calms, strict=True))
    return own or _in_chinese(clauses)


def _in_chinese(clauses: list[str]) -> bool:
    lists, rest = phrase_lists("resuming")["chinese"], "".join(clauses)
    if not any(sign in rest for sign in lists["go_on"]):
        return False
    for signs in (*lists["go_on"], *lists["calm"], *lists["besides"]):
        rest = rest.replace(signs, "")
    return not rest.strip()


@cache
def _patterns() -> tuple[re.Pattern[str], re.Pattern[str]]:
    """Return what matches a whole clause that says to go on, and one that is calm."""
    lists = phrase_lists("resuming")
    leads, tails = (longest_first(lists[name]["words"]) for name in ("leads", "tails"))
    go_on = "|".join((*lists["go_on"]["english"], *lists["go_on"]["foreign"]))
    calm = "|".join(lists["calm"]["clauses"])
    return (
        re.compile(rf"(?:{leads} )*(?:{go_on})(?: {tails})*"),
        re.compile(rf"(?:{leads}(?: |$))*(?:{calm}|(?:{leads}|{tails}))?(?: {tails})*"),
    )
