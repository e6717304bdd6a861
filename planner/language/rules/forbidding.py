"""From a sentence to what a person forbids."""

from __future__ import annotations

import re
from collections.abc import Iterator

from planner.language.rules.dangers import danger_in
from planner.language.rules.phrase_search import in_plain_letters, phrase_lists, whole_words
from planner.language.rules.warning import warns
from planner.person.prohibition import ACTS, Act, Prohibition

_CLAUSE = re.compile(r"[,;.!?:]|\bbut\b|\binstead\b")
_IMPERATIVE = r"(?:please )?(?:don't|dont|do not|never)\b"
_COMMANDS = re.compile(rf"(?:and |or )?{_IMPERATIVE}")
_OR = re.compile(rf" (?:or|nor|and(?= {_IMPERATIVE})) ")
TOUCHING: tuple[Act, ...] = ("clip", "cut")
_AND = r"(?:and|or|nor) (?:(?:the|your|cystic|on|of) )*"


def forbidden_in(text: str) -> tuple[Prohibition, ...]:
    """Return what an English sentence forbids; empty if it names no act.

    A denial in a request for what is dangerous, "cut it, I don't mind the clips", forbids nothing.
    What is excepted, "anything but the duct", is forbidden with the rest. A misread exception
    could not be undone, and a person soon allows one thing.
    """
    whole = in_plain_letters(text)
    if excepts(text) and warns(text):
        return tuple(Prohibition(act=act) for act in acts_in(whole)[:1])
    if (tube := _untouched(whole)) is not None and not acts_in(whole):
        return tuple(Prohibition(act=act, on=tube) for act in TOUCHING)
    clauses = [in_plain_letters(clause) for clause in _CLAUSE.split(text.lower())]
    found = list[Prohibition]()
    for k, words in enumerate(clauses):
        never = _find("never", words)
        if never is None or not acts_in(words) or (found and not _COMMANDS.match(words)):
            continue
        denied = words[never.end() :].strip()
        if never[0].startswith("only") and acts_in(before := words[: never.start()]):
            denied = before
        asked = danger_in(text) and not danger_in(" ".join((denied, *clauses[k + 1 :])))
        if not asked or _says_not_to_act(words[never.start() :]):
            found += _denied_in(denied if acts_in(denied) else words, words, whole)
    return tuple(dict.fromkeys(found))


def excepts(text: str) -> bool:
    """Return whether a sentence about acts makes an exception: "anything but the duct"."""
    words = in_plain_letters(text)
    found = _find("except", words)
    return found is not None and any(on_what(act, words[found.end() :]) for act in acts_in(words))


def _says_not_to_act(words: str) -> bool:
    """Return whether words begin like "don't cut"; "no clips on it" says how things are."""
    begun = re.match(rf"{_IMPERATIVE} (\w+)", words)
    return begun is not None and bool(acts_in(begun[1]))


def _denied_in(denied: str, words: str, whole: str) -> Iterator[Prohibition]:
    """Yield what the denied words of a clause forbid: "clip the duct or cut the artery".

    What an act is on may be said elsewhere in the clause, or in the `whole` sentence.
    """
    parts = list[str]()
    for part in _OR.split(denied):
        if parts and not acts_in(part):  # "cut the duct or the artery"
            parts[-1] += f" or {part}"
        else:
            parts.append(part)
    for part in parts:
        for act in acts_in(part):
            yield Prohibition(
                act=act, on=on_what(act, part) or on_what(act, words) or on_what(act, whole)
            )


def acts_in(words: str) -> tuple[Act, ...]:
    """Return the act that is named first, and one that is joined to it: "clip and cut"."""
    listed = {act: whole_words(ps) for act, ps in phrase_lists("forbidding")["acts"].items()}
    found = [(*m.span(), k) for k, act in enumerate(ACTS) for m in listed[act].finditer(words)]
    acts, end = list[Act](), 0
    for start, stop, k in sorted(found):
        if acts and words[end:start].strip() not in ("and", "or", "nor"):
            break
        acts.append(ACTS[k])
        end = stop
    return tuple(dict.fromkeys(acts))


def act_in(text: str) -> Prohibition | None:
    """Return the act that an English sentence names first, as what is forbidden or allowed."""
    words = in_plain_letters(text)
    acts = acts_in(words)
    return Prohibition(act=acts[0], on=on_what(acts[0], words)) if acts else None


def _untouched(words: str) -> str | None:
    """Return the tube that is to be left alone, not touched or not approached.

    "" stands for several tubes; None for none.
    """
    said = _find("never", words) and _find("touch", words) and not _find("elsewhere", words)
    tube = on_what("cut", words)
    return tube if said and (tube or _names_two("tube", words)) else None


def _find(kind: str, words: str) -> re.Match[str] | None:
    return whole_words(phrase_lists("forbidding")["who"][kind]).search(words)


def on_what(act: Act, words: str) -> str:
    """Return which gripper or tube is named first; "" for none, and for a pair of them."""
    kind = "gripper" if act == "open" else "tube"
    if _names_two(kind, words):
        return ""
    names = phrase_lists("forbidding")[f"{kind}s"]
    found = {name: whole_words(phrases).search(words) for name, phrases in names.items()}
    begin = {name: match.start() for name, match in found.items() if match}
    if not begin:
        return ""
    name = min(begin, key=begin.__getitem__)
    return f"{name} {kind}" if name in ("left", "right", "third") else name


def _names_two(kind: str, words: str) -> bool:
    """Return whether two grippers or tubes are named as a pair: "the duct or the artery"."""
    names = phrase_lists("forbidding")[f"{kind}s"]
    one = "|".join(phrase for phrases in names.values() for phrase in phrases)
    return whole_words((f"(?:{one}|left|right) {_AND}(?:{one})",)).search(words) is not None
