"""Argument types whose help says what they allow."""

import re
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import TypeVar

from tyro.constructors import PrimitiveConstructorSpec

from scenarios.evaluation.arm import FORM, StudyArm, arm_from_text

LONGEST_SHOWN = 40  # characters
FACTORY = "MODULE:FACTORY"
_FACTORY = re.compile(r"[A-Za-z_][\w.]*:[A-Za-z_][\w.]*")

T = TypeVar("T")

MOST = 100_000  # of anything that can be counted; assumed: months of episodes on one machine
MOST_SEED = 2**32 - 1
MOST_WORKERS = 1024
MOST_STEPS = 10**9  # of an optimiser


def at_least(minimum: int, most: int = MOST) -> PrimitiveConstructorSpec[int | None]:
    """Return the type of a whole number from `minimum` to `most`, to annotate int or None with."""

    def parse(word: str) -> int:
        if word.isdecimal() and (len(word.lstrip("0")) > len(str(most)) or int(word) > most):
            shown = word if len(word) <= LONGEST_SHOWN else f"{word[:LONGEST_SHOWN]}..."
            raise ValueError(f"{shown!r} is not a whole number of at most {most}")
        if not word.isdecimal() or int(word) < minimum:
            raise ValueError(f"{word!r} is not a whole number of at least {minimum}")
        return int(word)

    return _word("N", parse)


def number() -> PrimitiveConstructorSpec[float | None]:
    """Return the type of an optional number, to annotate a float | None with."""

    def parse(word: str) -> float:
        try:
            return float(word)
        except ValueError:
            raise ValueError(f"{word!r} is not a number") from None

    return _word("X", parse)


def one_of(names: Iterable[str]) -> PrimitiveConstructorSpec[str | None]:
    """Return the type of a name among `names`, to annotate a str or None with."""
    allowed = tuple(names)
    return _word(f"{{{','.join(allowed)}}}", partial(_require_one, allowed))


def policy_of(names: Iterable[str], other: str = FACTORY) -> PrimitiveConstructorSpec[str | None]:
    """Return the type of a name of what acts: among `names`, or one from outside."""
    return one_of((*names, other))


def some_of(names: Iterable[str]) -> PrimitiveConstructorSpec[tuple[str, ...] | None]:
    """Return the type of names among `names`, separated by commas, each once."""
    allowed = tuple(names)

    def parse(word: str) -> tuple[str, ...]:
        return tuple(dict.fromkeys(_require_one(allowed, name) for name in word.split(",")))

    return _word("NAME[,NAME...]", parse, ",".join)


def some_arms() -> PrimitiveConstructorSpec[tuple[StudyArm, ...]]:
    """Return the type of one or more arms of an evaluation."""

    def parse(words: list[str]) -> tuple[StudyArm, ...]:
        if not words:
            raise ValueError(f"there is none; allowed: {FORM}, once or more")
        return tuple(map(arm_from_text, words))

    return PrimitiveConstructorSpec(
        nargs="*",
        metavar=f"{FORM} ...",
        instance_from_str=parse,
        is_instance=lambda value: isinstance(value, tuple),
        str_from_instance=lambda value: [arm.name for arm in value],
    )


def text_of(path: Path | None) -> str | None:
    """Return a path as configurations keep it."""
    return None if path is None else str(path)


def _word(
    metavar: str, parse: Callable[[str], T], shown: Callable[[T], str] = str
) -> PrimitiveConstructorSpec[T | None]:
    """Return the type of one word; `shown` shows a default in the help."""
    return PrimitiveConstructorSpec(
        nargs=1,
        metavar=metavar,
        instance_from_str=lambda words: parse(words[0]),
        is_instance=lambda _: True,
        str_from_instance=lambda value: [str(value) if value is None else shown(value)],
    )


def _require_one(allowed: Sequence[str], word: str) -> str:
    outside = any(name.startswith("MODULE:") for name in allowed)
    if word in allowed or (outside and _FACTORY.fullmatch(word)):
        return word
    raise ValueError(f"unknown {word!r}; allowed: {', '.join(allowed)}")
