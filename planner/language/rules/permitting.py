"""From a sentence to the act that a person allows again, and whether that is sure.

A permission that is heard where a ban was meant may injure. So a text that denies or doubts
anything besides the ban that it ends allows nothing. One that reports, guesses or sets a time is
not sure.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

from planner.language.rules.forbidding import acts_in, excepts, on_what
from planner.language.rules.permission_frames import permitted_by
from planner.language.rules.phrase_search import in_plain_letters, phrase_lists, whole_words
from planner.language.rules.warning import warns
from planner.person.prohibition import Prohibition

_CLAUSE = re.compile(r"[,;.!?:,。;]")


@dataclass(frozen=True, kw_only=True)
class Permission:
    """What a person allows, and whether they surely do so now."""

    act: Prohibition
    sure: bool


def permission_in(text: str, english: str) -> Permission | None:
    """Return what a sentence allows again; None if it allows nothing, asks, denies or excepts.

    Args:
        text: as it was said.
        english: the words of commands in it.
    """
    if (act := permitted_by(text)) and not text.rstrip().endswith("?"):
        return Permission(act=act, sure=True)
    named = in_plain_letters(english)
    told = acts_in(named)
    if _denies(in_plain_letters(text), named):
        return None
    text, english = _as_it_stands(text), _as_it_stands(english)
    said, words = in_plain_letters(text), in_plain_letters(english)
    if excepts(english) or _asks(text, said):
        return None
    if clause := _built_like_one(text, words):
        return clause
    if not told:
        return None
    ended, rest = _without_ends(text)
    if warns(rest) or not (ended or _may(said) or _may(words)):
        return None
    clause = _clause_of(english)
    acts = acts_in(clause) or acts_in(words) or told
    act = Prohibition(
        act=acts[0],
        on=on_what(acts[0], clause) or on_what(acts[0], words) or on_what(acts[0], named),
    )
    return Permission(act=act, sure=not _is_unsure(said, words))


def permits_surely(text: str, english: str) -> bool:
    """Return whether nothing in a permission asks, reports, denies, excepts or sets a time."""
    said, words = in_plain_letters(text), in_plain_letters(english)
    doubtful = _denies(said, words) or _asks(text, said) or _is_unsure(said, words)
    return not (doubtful or excepts(english))


def _built_like_one(text: str, words: str) -> Permission | None:
    """Return what the one clause of a text permits that is built like a permission."""
    clauses = list(filter(None, map(in_plain_letters, _CLAUSE.split(text))))
    acts = {clause: act for clause in clauses if (act := permitted_by(clause))}
    rest = ", ".join(clause for clause in clauses if clause not in acts)
    if len(acts) != 1 or warns(rest):
        return None
    [act] = acts.values()
    act = act if act.on else replace(act, on=on_what(act.act, words))
    return Permission(act=act, sure=not _is_unsure(rest, rest))


def _as_it_stands(text: str) -> str:
    """Return a text without the clauses that take back what was said: "forget what I told you"."""
    back = whole_words(phrase_lists("permitting")["retracts"]["words"])
    clauses = (in_plain_letters(one) for one in _CLAUSE.split(text.replace("ing's", "ing is")))
    asks = "?" if text.rstrip().endswith("?") else ""
    return ", ".join(filter(None, (back.sub("", one).strip() for one in clauses))) + asks


def _clause_of(english: str) -> str:
    """Return the clause that allows; "" if none does by itself."""
    clauses = [in_plain_letters(clause) for clause in _CLAUSE.split(english)]
    return next((one for one in clauses if _may(one) or _ends(one)), "")


def _may(words: str) -> bool:
    return _find("may", words)


def _ends(words: str) -> bool:
    return _find("ends", words)


def _without_ends(text: str) -> tuple[bool, str]:
    """Return whether a text ends a ban, and the text without the words that do so."""
    lists, rest = phrase_lists("permitting")["ends"], list[str]()
    found = whole_words((*lists["english"], *lists["foreign"]))
    for clause in _CLAUSE.split(text):
        words = in_plain_letters(clause)
        for signs in lists["chinese"]:
            words = words.replace(signs, " ")
        rest.append(found.sub(" ", words))
    return _ends(in_plain_letters(text)), ", ".join(rest)


def _asks(text: str, said: str) -> bool:
    lists = phrase_lists("permitting")["denies"]
    if text.rstrip().endswith("?") or any(sign in said for sign in lists["chinese"]):
        return True
    asks = (*phrase_lists("forbidding")["who"]["asks"], *lists["asks"])
    return whole_words(asks).search(said) is not None


def _denies(said: str, words: str) -> bool:
    denial = whole_words(phrase_lists("permitting")["denies"]["words"])
    return bool(denial.search(said) or denial.search(words))


def _is_unsure(said: str, words: str) -> bool:
    later = phrase_lists("forbidding")["who"]["later"]
    lists = phrase_lists("permitting")["unsure"]
    doubts = whole_words((*lists["words"], *later))
    signs = any(sign in said for sign in lists["chinese"])
    return bool(signs or doubts.search(said) or doubts.search(words))


def _find(kind: str, words: str) -> bool:
    lists = phrase_lists("permitting")[kind]
    signs = any(sign in words for sign in lists["chinese"])
    return signs or whole_words((*lists["english"], *lists["foreign"])).search(words) is not None
