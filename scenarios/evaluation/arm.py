"""An arm of an evaluation: a planner, a controller, and options.

NAME=PLANNER+CONTROLLER[,filter=off][,checkpoint=FILE][,planner-checkpoint=FILE][,ablation=NAME]
[,sense=NAME][,perception-checkpoint=FILE][,person=NAME]
[,cameras=NAME+NAME][,without-rules=NAME+NAME]
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

from scenarios.catalogue import usual_sense
from scenarios.files.errors import BadInputError
from scenarios.loop.episode_config import Stack

FORM = "NAME=PLANNER+CONTROLLER[,OPTION=VALUE...]"
_NAMED = {"planner", "controller", "safety_filter"}  # before the options, or "filter"
OPTIONS = ("filter", *(f.name.replace("_", "-") for f in fields(Stack) if f.name not in _NAMED))
_SEVERAL = {"cameras", "without-rules"}
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+-]*")  # also a folder's


@dataclass(frozen=True, kw_only=True)
class StudyArm(Stack):
    """A compared system: a stack with a name.

    Attributes:
        name: unique in an evaluation; also the folder's name.
    """

    name: str


def arm_from_text(text: str) -> StudyArm:
    """Return the arm that a text describes; the default name is PLANNER+CONTROLLER.

    Raises:
        ValueError: the text has another form, or names something unknown.
    """
    stack, *options = text.split(",")
    name, named, parts = stack.rpartition("=")
    planner, plus, controller = parts.partition("+")
    name = name if named else parts
    if not plus or not _NAME.fullmatch(name):
        raise ValueError(f"{text!r} is no arm; allowed: {FORM}, as full=learned+diffusion")
    chosen: dict[str, Any] = {"sense": usual_sense(planner, controller)}
    chosen |= _options(options)
    return StudyArm(name=name, planner=planner, controller=controller, **chosen)


def _options(words: Sequence[str]) -> dict[str, Any]:
    given: dict[str, Any] = {}
    for word in words:
        name, _, value = word.partition("=")
        if name not in OPTIONS or not value:
            raise ValueError(f"unknown option {word!r}; allowed: {', '.join(OPTIONS)}, each =VALUE")
        given[name.replace("-", "_")] = tuple(value.split("+")) if name in _SEVERAL else value
    if len(given) < len(words):
        raise ValueError(f"{','.join(words)!r}: an option is given twice")
    if (switch := given.pop("filter", "on")) not in ("on", "off"):
        raise ValueError(f"filter={switch!r}; allowed: on, off")
    return given | {"safety_filter": switch == "on"}


def require_distinct(arms: Sequence[StudyArm]) -> None:
    """Check that no two arms have the same name.

    Raises:
        BadInputError: two arms have the same name.
    """
    names = [arm.name for arm in arms]
    if twice := {name for name in names if names.count(name) > 1}:
        raise BadInputError(f"--arms: {', '.join(sorted(twice))} is there twice; name them apart")
