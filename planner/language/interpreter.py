"""From free text to a command or a question back; warnings come before everything else."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING
from unicodedata import normalize

from planner.command import COMMANDS, Command
from planner.correction import CORRECTIONS, opposite
from planner.language.grammar import Parse, may_be_filled, openness, parse
from planner.language.reading import By, Reading, Said
from planner.language.rules.by_latest import by_latest
from planner.language.rules.claims import claims_in, without_claims
from planner.language.rules.compound import arm_named, in_order, names_an_act, parts_of
from planner.language.rules.corrected import as_corrected
from planner.language.rules.dangers import danger_in
from planner.language.rules.forbidding import act_in, excepts, forbidden_in
from planner.language.rules.foreign import in_english
from planner.language.rules.nothing_said import says_nothing
from planner.language.rules.pairs import without_other_arm
from planner.language.rules.permitting import Permission, permission_in, permits_surely
from planner.language.rules.phrase_search import in_plain_letters, patterns
from planner.language.rules.questions import (
    QUESTIONS,
    Question,
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
    out_of_range,
    speed_in,
    unclear_length,
    unread_length,
    without_size,
    without_speed,
    without_unit,
)
from planner.language.rules.small_talk import is_small_talk, without_asides
from planner.language.rules.spelling import as_meant, in_latin, with_third_tube
from planner.language.rules.warning import warns, warns_anywhere, warns_mildly, without_warning
from planner.language.slot_heads import SlotHeads, in_words, load
from planner.language.slots import spelt_out
from planner.person.prohibition import Prohibition
from tissue_sim.patient.tube_names import Tube

if TYPE_CHECKING:
    from planner.language.kind_head import Kind

MAX_CHARACTERS = 200  # longer texts are not understood,
LONGEST = 1000  # but warnings are heard in them
MAX_GUESSES = 3
MOST_PARTS = 6  # of a sentence with several commands
MIN_CHANCE = 0.05  # probability of a guess worth offering; assumed
_RE = patterns("interpreter")
STOP, PAUSE = COMMANDS["stop"], COMMANDS["pause"]
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
        return _not_understood(text, "it has characters that cannot be read")

    def _read(self, text: str, english: str) -> Reading:
        danger = danger_in(english)
        whole = _whole(text, english, danger)
        return whole or self._by_kind(self._by_rules(text, english, danger), english, danger)

    def _by_rules(self, text: str, english: str, danger: str) -> Reading:
        if warns(text) or warns(english):
            return self._warned(text, english, danger)
        if trouble := _trouble(text, english):
            return _not_understood(text, trouble)
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
        kind, sure = _kind_besides(ruled, english, danger)
        if kind is None or kind == ruled.question:
            return ruled
        text = ruled.text
        if kind in ("hold", "forbid"):
            return self._warned(text, english, danger, forbids=kind == "forbid")
        if kind in QUESTIONS:
            return _asked(text, kind)
        if kind == "resume":
            go_on = Said(command=COMMANDS["resume"])
            if sure:
                return _understood(text, go_on, 1.0, "classifier")
            return _asked_back(text, (go_on,), 0.5)
        if kind == "allow":
            return _allowed_besides(ruled, english, sure=sure)
        if kind == "refuse" and sure:
            return Reading(text=text, by="rule", reply="Refused: it sounds dangerous.")
        overruled = kind == "none" and ruled.by != "nobody"
        return _not_understood(text, "it is no business of mine") if overruled else ruled

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
        said = _by_grammar(english)
        question = question_in(english)
        if question and said is None and not danger and _asks_calmly(english) and "!" not in text:
            return _asked(text, question)
        if said in (STOP, PAUSE):
            reading = _understood(text, Said(command=said), 1.0, "grammar")
        else:
            reading = Reading(text=text, command=STOP, confidence=1.0, by="warning", reply="")
        banned = forbidden_in(english)
        if forbids and not banned and (act := act_in(english)):
            banned = (act,)
        rest = None if danger or banned else _sized(without_warning(english))
        clear = rest is not None and rest.command.moves and not _not_so_far(text, english, (rest,))
        meant = rest if clear else None
        return replace(
            reading,
            forbids=banned,
            guesses=() if meant is None or reading.by != "warning" else (meant,),
            reply=_banned(banned, english) or _what_is_held(reading, danger, meant),
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
        said = None if rest == english or _by_grammar(english) else _sized(rest)
        return None if said is None else _understood(text, said, 1.0, "grammar")

    def _commanded(self, text: str, english: str) -> Reading:
        """Return the reading of commands, or the question how far where that is not clear."""
        reading = self._several(text, english) or self._one(text, english)
        said = (*reading.said, *reading.guesses)
        why = _not_so_far(text, english, said)
        return Reading(text=text, reply=f"How far? {why}.") if why else reading

    def _several(self, text: str, english: str) -> Reading | None:
        """Return the reading of several commands in order, all of them or none."""
        parts = parts_of(english)
        if not 1 < len(parts) <= MOST_PARTS:
            return None
        read = list[Said | None]()
        for part in parts:
            before = read[-1] if read else None
            read.append(_as_before(part, before) or _sized(part) or way_back(part, before))
        said = tuple(one for one in read if one is not None)
        if not in_order(english):  # "go on and ..."
            said = tuple(o for o in said if o.command.word not in ("resume", "repeat")) or said
        if len({one.command.text for one in said}) < 2:
            missed = [p for one, p in zip(read, parts, strict=True) if one is None]
            half = said and " and " in english and any(map(names_an_act, missed))
            return self._half(text, said) if half else None
        if _contradict(said):
            return None
        whole = None if in_order(english) else _sized(english)
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
        return _asked_back(text, said[:MAX_GUESSES], 0.5)

    def _one(self, text: str, english: str) -> Reading:
        sized = without_size(english)
        plain, side = without_side(sized.text)
        parsed = parse(plain)
        command = None if parsed.refusal else spelt_out(parsed.filled)
        if command and _is_placed(command, sized, english):
            return _not_understood(text, "only an arm goes by a length, or farther to a side")
        if command and not (parsed.unknown and command.moves):
            return _understood(text, _said(command, sized.size_m, side), 1.0, "grammar")
        if (question := question_in(english)) is not None:
            return _asked(text, question)
        if parsed.refusal:
            return _not_understood(text, parsed.refusal)
        return self._guess(text, sized, parsed, side)

    def _guess(self, text: str, sized: Sized, parsed: Parse, side: Tube | None) -> Reading:
        from planner.language.sentence_encoder import embed  # PyTorch: seconds, once

        if not parsed.filled:
            return _not_understood(text, "no word of it names a motion, a clip, a cut or a side")
        ranked = self._heads.ranked(embed(in_words(sized.text)).numpy(), parsed.filled)
        confidence, best = ranked[0] if ranked else (0.0, None)
        sure = self._heads.thresholds[openness(parsed)]
        if best and confidence >= sure and may_be_filled(parsed, best):
            said = _said(best, sized.size_m, side)
            return _understood(text, said, confidence, "classifier")
        likely = (c for chance, c in ranked[:MAX_GUESSES] if chance >= MIN_CHANCE)
        guesses = tuple(_said(command, sized.size_m, side) for command in likely)
        return _asked_back(text, guesses, confidence)


def _kind_besides(ruled: Reading, english: str, danger: str) -> tuple[Kind | None, bool]:
    """Return what a text may be besides what rules read, and whether that is sure.

    None where rules are not in doubt. No order but to clip or cut is overruled.
    """
    text, order, warned = ruled.text, ruled.command, ruled.by == "warning"
    stops = order in (STOP, PAUSE) and not (warns(text) or warns(english))  # "freezing"
    ordered = order is not None and not (order.deed or warned or stops)
    if ordered or ruled.agrees or ruled.speed or ruled.applier or (warned and danger):
        return None, False
    from planner.language.kind_head import (  # PyTorch: seconds, once
        LETS_ACT,
        chances,
        kind_in,
        kind_instead,
    )

    found = chances(text)
    sure = kind_instead(found)
    confirmed = sure not in ("allow", "resume") or kind_instead(found, LETS_ACT) == sure
    if warned:
        return _instead_of_warning(ruled, english, found)
    if stops:
        return (sure if sure in (*QUESTIONS, "none") else None), True
    if ruled.question:
        return sure, confirmed
    if order:
        return (sure if sure in ("hold", "forbid") else None), True
    if _trouble(text, english):
        return None, False
    told = bool(ruled.guesses or claims_in(english))  # a claim is compared with what is seen
    kind = kind_in(found, guessed=told or bool(danger))
    holds = kind in ("hold", "forbid")
    unlike = is_small_talk(english) if holds else danger
    return None if unlike else kind, kind == sure and confirmed


def _instead_of_warning(
    ruled: Reading, english: str, found: Mapping[Kind, float]
) -> tuple[Kind | None, bool]:
    """Return what a text says that rules take for a warning, and whether that is sure.

    Where they hear a ban or a grave word and the head a permission, it may be either.
    """
    from planner.language.kind_head import LETS_ACT, kind_instead

    calm = kind_instead(found)
    if calm == "forbid":
        return (None if ruled.guesses else "forbid"), True  # "no, clip the duct" means to clip
    if ruled.forbids or not (warns_mildly(ruled.text) and warns_mildly(english)):
        return (calm if calm == "allow" else None), False
    if calm == "resume":
        return kind_instead(found, LETS_ACT), True
    return (calm if calm in (*QUESTIONS, "none", "allow") else None), calm != "allow"


def _whole(text: str, english: str, danger: str) -> Reading | None:
    """Return the reading of a text of which every word is known: it says nothing, to go on, ..."""
    if says_nothing(text):
        return Reading(text=text, by="rule", reply="No word for me.")
    if len(text) > MAX_CHARACTERS:
        return None
    if resumes(text) or resumes(english):
        return _understood(text, Said(command=COMMANDS["resume"]), 1.0, "grammar")
    if question := foreign_question_in(text):
        return _asked(text, question)
    if not danger and (permission := permission_in(with_third_tube(text), english)):
        return _permitted(text, english, permission)
    if said := by_latest(english):
        why = _not_so_far(text, english, (said,))
        if why:
            return Reading(text=text, reply=f"How far? {why}.")
        return replace(_understood(text, said, 1.0, "rule"), relative=said.relative)
    return None


def _allowed_besides(ruled: Reading, english: str, *, sure: bool) -> Reading:
    """Return the reading of a permission that the kind head finds; an unsure one lifts nothing."""
    act = act_in(english)
    if act is None or not (sure and permits_surely(ruled.text, english)):
        return replace(ruled, may_allow=act)
    told = f"{act.in_words}: not forbidden."
    return Reading(text=ruled.text, by="classifier", confidence=1.0, reply=told, allows=act)


def _permitted(text: str, english: str, given: Permission) -> Reading:
    """Return what is allowed, and the same act as a command, if it is spelt out."""
    allows = given.act if given.sure else None
    said = _sized(english) if given.sure else None
    opens = said is not None and given.act.act == "open" and not said.command.deed
    orders = said is not None and (opens or said.command.deed == given.act.act)
    reading = (
        _understood(text, said, 1.0, "grammar")
        if said and orders
        else Reading(
            text=text, by="rule", confidence=1.0, reply=f"{given.act.in_words}: not forbidden."
        )
    )
    return replace(reading, allows=allows, may_allow=None if given.sure else given.act)


def _asks_calmly(english: str) -> bool:
    """Return whether the only warning in a question is what it asks: "did it go wrong?"."""
    return not warns(_RE["asked_about"].sub("", english.lower()))


def _besides_speed(part: str) -> str:
    """Return what a part of a sentence asks for besides a speed; "" if nothing is understood."""
    if not speed_in(part):
        return part
    rest = without_speed(part)
    command = _by_grammar(rest)
    return rest if command and command.word != "repeat" else ""  # "normal speed again"


def _by_grammar(english: str) -> Command | None:
    """Return the command that an English sentence spells out; None if it does not."""
    parsed = parse(without_size(english).text)
    command = None if parsed.refusal else spelt_out(parsed.filled)
    return None if command is None or (parsed.unknown and command.moves) else command


def _sized(part: str) -> Said | None:
    sized = without_size(part)
    plain, side = without_side(sized.text)
    command = _by_grammar(plain)
    if command is None or _is_placed(command, sized, part):
        return None
    return _said(command, sized.size_m, side)


def _said(command: Command, size_m: float | None, side: Tube | None) -> Said:
    return Said(command=command, size_m=size_m if command.correction else None, side=side)


def _is_placed(command: Command, sized: Sized, english: str) -> bool:
    """Return whether a clip or a cut is to go to another place than its own: "2 mm higher"."""
    if not (command.deed or command.task):
        return False
    aside = _RE["aside"].search(english)
    return sized.measured or bool(aside and (aside["farther"] or sized.size_m))


def _not_so_far(text: str, english: str, said: Sequence[Said]) -> str:
    """Return why it is not clear how far an arm shall go, or it does not go so far; or ""."""
    sizes_m = [one.size_m for one in said if one.command.correction or one.relative]
    if not sizes_m:
        return ""
    if None in sizes_m and (number := without_unit(text)):
        return f"{number!r} is no length in mm, cm or inches"
    unclear = unclear_length(text) or unread_length(english)
    return unclear or next(filter(None, map(out_of_range, sizes_m)), "")


def _as_before(part: str, before: Said | None) -> Said | None:
    """Return the motion of a part that says it by the one before: "left likewise"."""
    echo, motion = echo_in(part), before and before.command.correction
    if echo is None or before is None or motion is None or not motion.direction:
        return None
    if before.size_m is None and echo.times != 1.0:
        return None
    size_m = before.size_m and before.size_m * echo.times
    own = _by_grammar(echo.text)
    if own is not None:
        return Said(command=own, size_m=size_m) if own.correction else None
    arm = arm_named(echo.text + " arm") or arm_named(echo.text)
    same = (c for c in CORRECTIONS if (c.arm, c.direction) == (arm, motion.direction))
    return next((Said(command=COMMANDS[c.text], size_m=size_m) for c in same), None)


def _contradict(said: tuple[Said, ...]) -> bool:
    """Return whether motions without a size undo the one before: "up and down"."""
    ways = [None if one.size_m else one.command.correction for one in said]
    return any(a and b and a == opposite(b) for a, b in pairwise(ways))


def _trouble(text: str, english: str) -> str:
    """Return why a text cannot be read at all; empty if it can."""
    if not text.strip():
        return "nothing was said"
    if len(text) > MAX_CHARACTERS:
        return f"it is longer than {MAX_CHARACTERS} characters"
    foreign = any(one.isalpha() and not one.isascii() for one in normalize("NFKC", english))
    if foreign and question_in(english) is None:
        return "it is in no language that is understood"
    return ""


def _understood(text: str, said: Said, confidence: float, by: By) -> Reading:
    return Reading(
        text=text,
        command=said.command,
        size_m=said.size_m,
        side=said.side,
        confidence=confidence,
        by=by,
        reply=f"Understood: {said.text}.",
    )


def _banned(forbids: tuple[Prohibition, ...], english: str) -> str:
    """Return in words what is forbidden from now on; empty if nothing is."""
    if not forbids:
        return ""
    acts = ", ".join(one.in_words for one in forbids)
    if excepts(english):
        acts += f', without exception; for one, say "you may {forbids[0].act} ..."'
    return f"Forbidden until you allow it: {acts}."


def _what_is_held(reading: Reading, danger: str, meant: Said | None) -> str:
    if danger:
        return f"Refused: {danger}."
    if reading.by != "warning":
        return reading.reply
    return f'Did you mean "{meant.text}"?' if meant else "What is wrong? Say what to do, or resume."


def _asked(text: str, question: Question) -> Reading:
    return Reading(
        text=text, question=question, confidence=1.0, by="rule", reply=f"Question: {question}."
    )


def _not_understood(text: str, why: str) -> Reading:
    return Reading(text=text, reply=f"Not understood: {why}.")


def _asked_back(text: str, guesses: tuple[Said, ...], confidence: float) -> Reading:
    if not guesses:
        return _not_understood(text, "it may mean too many things, or none")
    meant = " or ".join(f'"{guess.text}"' for guess in guesses)
    return Reading(
        text=text, guesses=guesses, confidence=confidence, reply=f"Did you mean {meant}?"
    )
