"""Is a clause built like a permission? A frame that permits, around an act and what it is on.

Each word of such a clause is known, so that no denial, condition or report hides in it.
permission_frames.toml lists the frames of six languages.
"""

from __future__ import annotations

import re
from functools import cache
from typing import cast

from planner.language.rules.phrase_search import filled, in_plain_letters, phrase_lists
from planner.person.prohibition import Act, Prohibition

_SIGN = re.compile(r"([\u4e00-\u9fff])")  # each Chinese one is a word


def permitted_by(clause: str) -> Prohibition | None:
    """Return the act that a whole clause permits; None if it is not built like a permission."""
    words = _SIGN.sub(r" \1 ", in_plain_letters(clause).replace("'", " "))
    words, things = _with_signs(" ".join(words.split()), "things", "#")
    words, named = _with_signs(words, "doing", "@ing")
    words, acts = _with_signs(words, "acts", "@")
    acts = (*named, *acts)
    plain = " ".join(_idle().sub(" ", words).split())
    if len(acts) != 1 or len(things) > 1 or not _frames().fullmatch(plain):
        return None
    ban = Prohibition(act=cast("Act", acts[0]), on="".join(things))
    return ban if not ban.on or (ban.act == "open") == ban.on.endswith("gripper") else None


def _with_signs(words: str, table: str, sign: str) -> tuple[str, tuple[str, ...]]:
    """Return a text with a sign for each phrase of a table, and which ones they were."""
    found = list[str]()

    def signed(match: re.Match[str]) -> str:
        found.append(cast("str", match.lastgroup).replace("_", " "))
        return sign

    return _any_of(table).sub(signed, words), tuple(found)


@cache
def _any_of(table: str) -> re.Pattern[str]:
    lists = phrase_lists("permission_frames")[table]
    groups = (
        f"(?P<{name.replace(' ', '_')}>{_longest_first(phrases)})"
        for name, phrases in lists.items()
    )
    return re.compile(rf"(?<!\w)(?:{'|'.join(groups)})(?!\w)")


@cache
def _idle() -> re.Pattern[str]:
    words = phrase_lists("permission_frames")["idle"]["words"]
    return re.compile(rf"(?<!\w)(?:{_longest_first(words)})(?!\w)")


def _longest_first(phrases: tuple[str, ...]) -> str:
    return "|".join(sorted(phrases, key=len, reverse=True))


@cache
def _frames() -> re.Pattern[str]:
    """Return what matches a whole clause, its phrases replaced by signs, that permits."""
    lists = phrase_lists("permission_frames")
    parts = {name: f"(?:{'|'.join(phrases)})" for name, phrases in lists["parts"].items()}
    frames = "|".join(filled(one, parts) for ones in lists["frames"].values() for one in ones)
    leads = "|".join(lists["leads"]["words"])
    return re.compile(rf"(?:(?:{leads}) )*(?:{frames})")
