"""Argument types whose help says what they allow."""

import re
from collections.abc import Iterable
from pathlib import Path

from tyro.constructors import PrimitiveConstructorSpec

from scenarios.evaluation.arm import FORM, StudyArm, arm_from_text

LONGEST_SHOWN = 40  # characters
_FACTORY = re.compile(r"[A-Za-z_][\w.]*:[A-Za-z_][\w.]*")


MOST = 100_000  # of anything that can be counted; assumed: months of episodes on one machine
MOST_SEED = 2**32 - 1
MOST_WORKERS = 1024
MOST_STEPS = 10**9  # of an optimiser


def at_least(minimum: int, most: int = MOST) -> PrimitiveConstructorSpec[int | None]:
    """Return the type of a whole number from `minimum` to `most`, to annotate int or None with."""

    def parse(words: list[str]) -> int:
        word = words[0]
        if not word.isdecimal():
            raise ValueError(f"{word!r} is not a whole number of at least {minimum}")
        if len(word.lstrip("0")) > len(str(most)) or int(word) > most:
            shown = word if len(word) <= LONGEST_SHOWN else f"{word[:LONGEST_SHOWN]}..."
            raise ValueError(f"{shown!r} is not a whole number of at most {most}")
        if int(word) < minimum:
            raise ValueError(f"{word!r} is not a whole number of at least {minimum}")
        return int(word)

    return PrimitiveConstructorSpec(
        nargs=1,
        metavar="N",
        instance_from_str=parse,
        is_instance=lambda value: value is None or isinstance(value, int),
        str_from_instance=lambda value: [str(value)],
    )


def number() -> PrimitiveConstructorSpec[float | None]:
    """Return the type of an optional number, to annotate a float | None with."""

    def parse(words: list[str]) -> float:
        try:
            return float(words[0])
        except ValueError:
            raise ValueError(f"{words[0]!r} is not a number") from None

    return PrimitiveConstructorSpec(
        nargs=1,
        metavar="X",
        instance_from_str=parse,
        is_instance=lambda value: value is None or isinstance(value, float),
        str_from_instance=lambda value: [str(value)],
    )


def one_of(names: Iterable[str]) -> PrimitiveConstructorSpec[str | None]:
    """Return the type of a name among `names`, to annotate a str or None with."""
    allowed = tuple(names)

    def parse(words: list[str]) -> str:
        if words[0] not in allowed:
            raise ValueError(f"unknown {words[0]!r}; allowed: {', '.join(allowed)}")
        return words[0]

    return PrimitiveConstructorSpec(
        nargs=1,
        metavar=f"{{{','.join(allowed)}}}",
        instance_from_str=parse,
        is_instance=lambda value: value is None or isinstance(value, str),
        str_from_instance=lambda value: [str(value)],
    )


def policy_of(
    names: Iterable[str], other: str = "MODULE:FACTORY"
) -> PrimitiveConstructorSpec[str | None]:
    """Return the type of a name of what acts: among `names`, or one from outside."""
    allowed = (*names, other)

    def parse(words: list[str]) -> str:
        if words[0] not in allowed and not _FACTORY.fullmatch(words[0]):
            raise ValueError(f"unknown {words[0]!r}; allowed: {', '.join(allowed)}")
        return words[0]

    return PrimitiveConstructorSpec(
        nargs=1,
        metavar=f"{{{','.join(allowed)}}}",
        instance_from_str=parse,
        is_instance=lambda value: value is None or isinstance(value, str),
        str_from_instance=lambda value: [str(value)],
    )


def text_of(path: Path | None) -> str | None:
    """Return a path as configurations keep it."""
    return None if path is None else str(path)


def some_of(names: Iterable[str]) -> PrimitiveConstructorSpec[tuple[str, ...]]:
    """Return the type of names among `names`, separated by commas, each once."""
    allowed = tuple(names)

    def parse(words: list[str]) -> tuple[str, ...]:
        given = tuple(dict.fromkeys(words[0].split(",")))
        for name in given:
            if name not in allowed:
                raise ValueError(f"unknown {name!r}; allowed: {', '.join(allowed)}")
        return given

    return PrimitiveConstructorSpec(
        nargs=1,
        metavar="NAME[,NAME...]",
        instance_from_str=parse,
        is_instance=lambda value: isinstance(value, tuple),
        str_from_instance=lambda value: [",".join(value)],
    )


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
