"""Encode a command: the sentences of task and correction, and the same as numbers, the token.

Sentences alone do not tell commands apart: the embeddings of opposite directions have a cosine of
0.98. No sentence has the distance that is left.
"""

from __future__ import annotations

from functools import cache

import torch
from torch import Tensor
from torch.nn import functional as F

from controller.dataset.schema import UNNAMED
from controller.diffusion.config import PROCEDURE, WORDS_SIZE, PolicyConfig
from planner.correction import CORRECTIONS, DIRECTION_ENDOSCOPE, Correction
from planner.instruction import Instruction
from planner.language.sentence_encoder import embed_all
from planner.procedure.cholecystectomy import TASKS

NONE = -1  # the correction's row when there is none
SCALES_M = (0.0015, 0.005, 0.02)  # of the distance that is left: of slowing down to the whole
SCALE_RAD = 0.2
ENDLESS = (0.05, 1.5)  # m and rad, for what was not named: farther than any that is
OF_CORRECTION, OF_LEFT = 8, 22  # numbers of a token
TOKEN_SIZE = len(TASKS) + OF_CORRECTION + OF_LEFT
ARMS, ALONG, JAWS = slice(1, 3), slice(3, 6), slice(6, 8)  # of the numbers of a correction


def encoded(said: Instruction, config: PolicyConfig) -> dict[str, Tensor]:
    """Return a policy's inputs for an instruction: "words" (2, 384) and "token" (`TOKEN_SIZE`,)."""
    task, correction, left = 0, NONE, [UNNAMED, UNNAMED]
    if not config.wordless:
        task = said.task.index - 1
        left = [UNNAMED if part is None else part for part in (said.left_m, said.left_rad)]
        if said.correction is not None:
            correction = CORRECTIONS.index(said.correction)
    tasks, corrections = sentences(config)
    return {
        "words": torch.stack([tasks[task], corrections[correction - NONE]]),
        "token": tokens(torch.tensor([task]), torch.tensor([correction]), torch.tensor([left]))[0],
    }


@cache
def sentences(config: PolicyConfig) -> tuple[Tensor, Tensor]:
    """Return the embeddings of tasks (25, 384), and of no correction and the 18 (19, 384).

    A wordless policy gets the same for all tasks, and zeros for all corrections.
    """
    none = torch.zeros(1, WORDS_SIZE)
    if config.wordless:
        procedure = embed_all((PROCEDURE,))
        return procedure.expand(len(TASKS), -1), none.expand(1 + len(CORRECTIONS), -1)
    said = embed_all(tuple(c.text for c in CORRECTIONS))
    return embed_all(tuple(task.text for task in TASKS)), torch.cat([none, said])


def tokens(task: Tensor, correction: Tensor, left: Tensor) -> Tensor:
    """Return the tokens (B, `TOKEN_SIZE`) of commands.

    Args:
        task: (B,) rows of `TASKS`.
        correction: (B,) rows of `CORRECTIONS`, or `NONE`.
        left: (B, 2) the distance, m, and the opening of the jaws, rad, that are left of the
            correction; `UNNAMED` where none was named.
    """
    named, said = left > 0.5 * UNNAMED, F.embedding(correction - NONE, _of_corrections().to(left))
    left_m, left_rad = torch.where(named, left, left.new_tensor(ENDLESS)).split(1, dim=-1)
    ways = torch.tanh(left_m / left.new_tensor(SCALES_M))  # below zero where the arm went too far
    parts = [
        F.one_hot(task, len(TASKS)).to(left),
        said,
        named.to(left),
        (ways_of(correction).to(left).flatten(1)[:, :, None] * ways[:, None]).flatten(1),
        said[:, JAWS] * torch.tanh(left_rad.clamp(min=0.0) / SCALE_RAD),
    ]
    return torch.cat(parts, dim=-1)


def ways_of(correction: Tensor) -> Tensor:
    """Return (B, 2, 3) the unit way of each arm, endoscope frame, by rows (B,) of corrections.

    An arm that does not go anywhere has zeros.
    """
    said = F.embedding(correction - NONE, _of_corrections().to(correction.device))
    return said[:, ARMS, None] * said[:, None, ALONG]


@cache
def _of_corrections() -> Tensor:
    rows = [_of_correction(correction) for correction in CORRECTIONS]
    return torch.tensor([[0.0] * OF_CORRECTION, *rows])


def _of_correction(correction: Correction) -> list[float]:
    """Return one, which arms move, the direction, and how each arm's jaws move."""
    named = [float(arm in correction.rows) for arm in (0, 1)]
    along = DIRECTION_ENDOSCOPE[correction.direction] if correction.direction else (0.0, 0.0, 0.0)
    sign = {"open": 1.0, "close": -1.0, None: 0.0}[correction.jaw]
    return [1.0, *named, *along, *(sign * arm for arm in named)]


@cache
def of_jaws() -> Tensor:
    """Return (19,) whether no correction, and each correction, is of the jaws."""
    return torch.tensor([False, *(correction.jaw is not None for correction in CORRECTIONS)])
