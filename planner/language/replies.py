"""Make readings of texts, each with its reply to the person."""

from __future__ import annotations

from dataclasses import replace

from planner.language.reading import By, Reading, Said
from planner.language.rules.forbidding import act_in, excepts
from planner.language.rules.permitting import Permission, permits_surely
from planner.language.rules.questions import Question
from planner.language.spelt_command import sized_in
from planner.person.prohibition import Prohibition


def understood(text: str, said: Said, confidence: float, by: By) -> Reading:
    """Return the reading of a text that says one command."""
    return Reading(
        text=text,
        command=said.command,
        size_m=said.size_m,
        side=said.side,
        confidence=confidence,
        by=by,
        reply=f"Understood: {said.text}.",
    )


def asked(text: str, question: Question) -> Reading:
    """Return the reading of a question."""
    return Reading(
        text=text, question=question, confidence=1.0, by="rule", reply=f"Question: {question}."
    )


def asked_back(text: str, guesses: tuple[Said, ...], confidence: float) -> Reading:
    """Return the reading of a text that may mean one of some guesses, and asks which."""
    if not guesses:
        return not_understood(text, "it may mean too many things, or none")
    meant = " or ".join(f'"{guess.text}"' for guess in guesses)
    return Reading(
        text=text, guesses=guesses, confidence=confidence, reply=f"Did you mean {meant}?"
    )


def not_understood(text: str, why: str) -> Reading:
    """Return the reading of a text that means nothing to the robot, with the reason."""
    return Reading(text=text, reply=f"Not understood: {why}.")


def banned_in_words(forbids: tuple[Prohibition, ...], english: str) -> str:
    """Return in words what is forbidden from now on; empty if nothing is."""
    if not forbids:
        return ""
    acts = ", ".join(one.in_words for one in forbids)
    if excepts(english):
        acts += f', without exception; for one, say "you may {forbids[0].act} ..."'
    return f"Forbidden until you allow it: {acts}."


def held_in_words(reading: Reading, danger: str, meant: Said | None) -> str:
    """Return the reply to a warning: what is refused, or what else may be meant."""
    if danger:
        return f"Refused: {danger}."
    if reading.by != "warning":
        return reading.reply
    return f'Did you mean "{meant.text}"?' if meant else "What is wrong? Say what to do, or resume."


def permitted(text: str, english: str, given: Permission) -> Reading:
    """Return what is allowed, and the same act as a command, if it is spelt out."""
    allows = given.act if given.sure else None
    said = sized_in(english) if given.sure else None
    opens = said is not None and given.act.act == "open" and not said.command.deed
    orders = said is not None and (opens or said.command.deed == given.act.act)
    reading = (
        understood(text, said, 1.0, "grammar")
        if said and orders
        else Reading(
            text=text, by="rule", confidence=1.0, reply=f"{given.act.in_words}: not forbidden."
        )
    )
    return replace(reading, allows=allows, may_allow=None if given.sure else given.act)


def allowed_besides(ruled: Reading, english: str, *, sure: bool) -> Reading:
    """Return the reading of a permission that the kind head finds; an unsure one lifts nothing."""
    act = act_in(english)
    if act is None or not (sure and permits_surely(ruled.text, english)):
        return replace(ruled, may_allow=act)
    told = f"{act.in_words}: not forbidden."
    return Reading(text=ruled.text, by="classifier", confidence=1.0, reply=told, allows=act)
