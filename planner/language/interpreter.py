"""From free text to a command or a question back; warnings come before everything else."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from itertools import pairwise

from planner.command import COMMANDS
from planner.correction import CORRECTIONS, opposite
from planner.language.grammar import Parse, may_be_filled, openness, parse
from planner.language.kind_besides import (
    MAX_CHARACTERS,
    PAUSE,
    STOP,
    kind_besides,
    trouble_in,
)
from planner.language.reading import Reading, Said
from planner.language.replies import (
    allowed_besides,
    asked,
    asked_back,
    banned_in_words,
    held_in_words,
    not_understood,
    permitted,
    understood,
)
from planner.language.rules.by_latest import by_latest
from planner.language.rules.claims import claims_in, without_claims
from planner.language.rules.compound import arm_named, in_order, names_an_act, parts_of
from planner.language.rules.corrected import as_corrected
from planner.language.rules.dangers import danger_in
from planner.language.rules.forbidding import act_in, forbidden_in
from planner.language.rules.foreign import in_english
from planner.language.rules.nothing_said import says_nothing
from planner.language.rules.pairs import without_other_arm
from planner.language.rules.permitting import permission_in
from planner.language.rules.phrase_search import in_plain_letters, patterns
from planner.language.rules.questions import (
    QUESTIONS,
    foreign_question_in,
    question_in,
    thing_in,
)
from planner.language.rules.references import (
    applier_in,
    way_back,
    with_plain_ordinals,
    without_side,
)
from planner.language.rules.resuming import resumes
from planner.language.rules.sizes import (
    Sized,
    echo_in,
    speed_in,
    without_size,
    without_speed,
)
from planner.language.rules.small_talk import without_asides
from planner.language.rules.spelling import as_meant, in_latin, with_third_tube
from planner.language.rules.warning import warns, warns_anywhere, without_warning
from planner.language.slot_heads import SlotHeads, in_words, load
from planner.language.slots import spelt_out
from planner.language.spelt_command import (
    by_grammar,
    is_placed,
    not_so_far,
    said_with,
    sized_in,
)
from tissue_sim.patient.tube_names import Tube

LONGEST = 1000  # characters; in longer texts warnings are heard
MAX_GUESSES = 3
MOST_PARTS = 6  # of a sentence with several commands
MIN_CHANCE = 0.05  # probability of a guess worth offering; assumed
_RE = patterns("interpreter")
_UNLISTED = "qqqq the left arm higher"


class Interpreter:
    """Reads free text; it loads the sentence encoder when a sentence first needs it."""

    def read(self, text: str) -> Reading:
        """Return the meaning of any text; never raise. Of a very long one the beginning counts."""
        latin = in_latin(text)
        seen = latin[:LONGEST]
        meant = with_third_tube(in_english(as_meant(with_third_tube(seen))))
        english = with_plain_ordinals(without_other_arm(as_corrected(without_asides(meant))))
        if warns_anywhere(latin[LONGEST:]):
            return replace(self._warned(seen, english, danger_in(english)), text=text)
        hidden = text.strip() and not text[:LONGEST].strip().isprintable()
        read = self._hidden(seen, english) if hidden else self._read(seen, english)
        return replace(read, text=text, about=thing_in(english), claims=claims_in(meant))

    def _hidden(self, text: str, english: str) -> Reading:
        """Return the reading of a text with characters that are not seen: only warnings count."""
        if warns(text) or warns(english):
            return self._warned(text, english, danger_in(english))
        return not_understood(text, "it has characters that cannot be read")

    def _read(self, text: str, english: str) -> Reading:
        danger = danger_in(english)
        whole = _whole(text, english, danger)
        return whole or self._by_kind(self._by_rules(text, english, danger), english, danger)

    def _by_rules(self, text: str, english: str, danger: str) -> Reading:
        if warns(text) or warns(english):
            return self._warned(text, english, danger)
        if trouble := trouble_in(text, english):
            return not_understood(text, trouble)
        if _RE["yes"].fullmatch(in_plain_letters(text)):
            return Reading(text=text, agrees=True, by="rule", reply="There is nothing to agree to.")
        if danger:
            return Reading(text=text, by="rule", reply=f"Refused: {danger}.")
        if speed := speed_in(english):
            return self._at_speed(text, english, speed)
        if chosen := self._with_applier(text, english):
            return chosen
        return self._besides_claims(text, english) or self._commanded(text, english)

    def _by_kind(self, ruled: Reading, english: str, danger: str) -> Reading:
        """Let the kind head read what rules do not, and overrule them where it is sure."""
        kind, sure = kind_besides(ruled, english, danger)
        if kind is None or kind == ruled.question:
            return ruled
        text = ruled.text
        if kind in ("hold", "forbid"):
            return self._warned(text, english, danger, forbids=kind == "forbid")
        if kind in QUESTIONS:
            return asked(text, kind)
        if kind == "resume":
            go_on = Said(command=COMMANDS["resume"])
            if sure:
                return understood(text, go_on, 1.0, "classifier")
            return asked_back(text, (go_on,), 0.5)
        if kind == "allow":
            return allowed_besides(ruled, english, sure=sure)
        if kind == "refuse" and sure:
            return Reading(text=text, by="rule", reply="Refused: it sounds dangerous.")
        overruled = kind == "none" and ruled.by != "nobody"
        return not_understood(text, "it is no business of mine") if overruled else ruled

    def warm_up(self) -> None:
        """Load the sentence encoder, so that the first unknown word does not wait for seconds."""
        self.read(_UNLISTED)

    @cached_property
    def _heads(self) -> SlotHeads:
        return load()

    def _warned(self, text: str, english: str, danger: str, *, forbids: bool = False) -> Reading:
        """Return the reading of a warning: hold, and ask what was meant by the rest.

        `forbids` tells that the act it names is forbidden, though no rule finds a denial.
        """
        said = by_grammar(english)
        question = question_in(english)
        if question and said is None and not danger and asks_calmly(english) and "!" not in text:
            return asked(text, question)
        if said in (STOP, PAUSE):
            reading = understood(text, Said(command=said), 1.0, "grammar")
        else:
            reading = Reading(text=text, command=STOP, confidence=1.0, by="warning", reply="")
        banned = forbidden_in(english)
        if forbids and not banned and (act := act_in(english)):
            banned = (act,)
        rest = None if danger or banned else sized_in(without_warning(english))
        clear = rest is not None and rest.command.moves and not not_so_far(text, english, (rest,))
        meant = rest if clear else None
        return replace(
            reading,
            forbids=banned,
            guesses=() if meant is None or reading.by != "warning" else (meant,),
            reply=banned_in_words(banned, english) or held_in_words(reading, danger, meant),
        )

    def _at_speed(self, text: str, english: str, speed: str) -> Reading:
        """Return the reading of words about speed, and of what else the sentence asks for."""
        rest = ", then ".join(filter(None, map(_besides_speed, parts_of(english))))
        told = f"Speed: {speed}."
        alone = Reading(text=text, speed=speed, confidence=1.0, by="rule", reply=told)
        if not rest:
            return alone
        read = self._commanded(text, rest)
        besides = replace(read, speed=speed, reply=f"{told} {read.reply}")
        return besides if read.command or names_an_act(rest) else alone

    def _with_applier(self, text: str, english: str) -> Reading | None:
        """Return the reading of a choice of clips, and of what else is asked; None if unclear."""
        wanted = None if question_in(english) else applier_in(english)
        if wanted is None:
            return None
        applier, rest = wanted
        told = f"Clip applier: {applier}."
        if not rest:
            return Reading(text=text, applier=applier, confidence=1.0, by="rule", reply=told)
        read = self._commanded(text, rest)
        besides = replace(read, applier=applier, reply=f"{told} {read.reply}")
        return besides if read.command else None

    def _besides_claims(self, text: str, english: str) -> Reading | None:
        """Return what is commanded besides what is taken for so: "now that it is cut, clip ...".

        None where the whole sentence is understood, or the rest is not.
        """
        rest = without_claims(english)
        said = None if rest == english or by_grammar(english) else sized_in(rest)
        return None if said is None else understood(text, said, 1.0, "grammar")

    def _commanded(self, text: str, english: str) -> Reading:
        """Return the reading of commands, or the question how far where that is not clear."""
        reading = self._several(text, english) or self._one(text, english)
        said = (*reading.said, *reading.guesses)
        why = not_so_far(text, english, said)
        return Reading(text=text, reply=f"How far? {why}.") if why else reading

    def _several(self, text: str, english: str) -> Reading | None:
        """Return the reading of several commands in order, all of them or none."""
        parts = parts_of(english)
        if not 1 < len(parts) <= MOST_PARTS:
            return None
        read = list[Said | None]()
        for part in parts:
            before = read[-1] if read else None
            read.append(_as_before(part, before) or sized_in(part) or way_back(part, before))
        said = tuple(one for one in read if one is not None)
        if not in_order(english):  # "go on and ..."
            said = tuple(o for o in said if o.command.word not in ("resume", "repeat")) or said
        if len({one.command.text for one in said}) < 2:
            missed = [p for one, p in zip(read, parts, strict=True) if one is None]
            half = said and " and " in english and any(map(names_an_act, missed))
            return self._half(text, said) if half else None
        if _contradict(said):
            return None
        whole = None if in_order(english) else sized_in(english)
        moves = all(one.command.correction for one in said)
        first_acts = said[0].command.deed or said[0].command.task
        both_meant = moves or (first_acts and " and " in english)
        if whole is not None and whole.command != said[0].command and not both_meant:
            return None
        if any(one is None for one in read):
            return self._half(text, said)
        first, *then = said
        words = ", then ".join(one.text for one in said)
        return Reading(
            text=text,
            command=first.command,
            size_m=first.size_m,
            side=first.side,
            then=tuple(then),
            confidence=1.0,
            by="grammar",
            reply=f"Understood: {words}.",
        )

    def _half(self, text: str, said: tuple[Said, ...]) -> Reading:
        """Ask back where only some parts of a sentence are understood: half is never done."""
        return asked_back(text, said[:MAX_GUESSES], 0.5)

    def _one(self, text: str, english: str) -> Reading:
        sized = without_size(english)
        plain, side = without_side(sized.text)
        parsed = parse(plain)
        command = None if parsed.refusal else spelt_out(parsed.filled)
        if command and is_placed(command, sized, english):
            return not_understood(text, "only an arm goes by a length, or farther to a side")
        if command and not (parsed.unknown and command.moves):
            return understood(text, said_with(command, sized.size_m, side), 1.0, "grammar")
        if (question := question_in(english)) is not None:
            return asked(text, question)
        if parsed.refusal:
            return not_understood(text, parsed.refusal)
        return self._guess(text, sized, parsed, side)

    def _guess(self, text: str, sized: Sized, parsed: Parse, side: Tube | None) -> Reading:
        from planner.language.sentence_encoder import embed  # PyTorch: seconds, once

        if not parsed.filled:
            return not_understood(text, "no word of it names a motion, a clip, a cut or a side")
        ranked = self._heads.ranked(embed(in_words(sized.text)).numpy(), parsed.filled)
        confidence, best = ranked[0] if ranked else (0.0, None)
        sure = self._heads.thresholds[openness(parsed)]
        if best and confidence >= sure and may_be_filled(parsed, best):
            said = said_with(best, sized.size_m, side)
            return understood(text, said, confidence, "classifier")
        likely = (c for chance, c in ranked[:MAX_GUESSES] if chance >= MIN_CHANCE)
        guesses = tuple(said_with(command, sized.size_m, side) for command in likely)
        return asked_back(text, guesses, confidence)


def _whole(text: str, english: str, danger: str) -> Reading | None:
    """Return the reading of a text of which every word is known: it says nothing, to go on, ..."""
    if says_nothing(text):
        return Reading(text=text, by="rule", reply="No word for me.")
    if len(text) > MAX_CHARACTERS:
        return None
    if resumes(text) or resumes(english):
        return understood(text, Said(command=COMMANDS["resume"]), 1.0, "grammar")
    if question := foreign_question_in(text):
        return asked(text, question)
    if not danger and (permission := permission_in(with_third_tube(text), english)):
        return permitted(text, english, permission)
    if said := by_latest(english):
        why = not_so_far(text, english, (said,))
        if why:
            return Reading(text=text, reply=f"How far? {why}.")
        return replace(understood(text, said, 1.0, "rule"), relative=said.relative)
    return None


def asks_calmly(english: str) -> bool:
    """Return whether the only warning in a question is what it asks: "did it go wrong?"."""
    return not warns(_RE["asked_about"].sub("", english.lower()))


def _besides_speed(part: str) -> str:
    """Return what a part of a sentence asks for besides a speed; "" if nothing is understood."""
    if not speed_in(part):
        return part
    rest = without_speed(part)
    command = by_grammar(rest)
    return rest if command and command.word != "repeat" else ""  # "normal speed again"


def _as_before(part: str, before: Said | None) -> Said | None:
    """Return the motion of a part that says it by the one before: "left likewise"."""
    echo, motion = echo_in(part), before and before.command.correction
    if echo is None or before is None or motion is None or not motion.direction:
        return None
    if before.size_m is None and echo.times != 1.0:
        return None
    size_m = before.size_m and before.size_m * echo.times
    own = by_grammar(echo.text)
    if own is not None:
        return Said(command=own, size_m=size_m) if own.correction else None
    arm = arm_named(echo.text + " arm") or arm_named(echo.text)
    same = (c for c in CORRECTIONS if (c.arm, c.direction) == (arm, motion.direction))
    return next((Said(command=COMMANDS[c.text], size_m=size_m) for c in same), None)


def _contradict(said: tuple[Said, ...]) -> bool:
    """Return whether motions without a size undo the one before: "up and down"."""
    ways = [None if one.size_m else one.command.correction for one in said]
    return any(a and b and a == opposite(b) for a, b in pairwise(ways))
