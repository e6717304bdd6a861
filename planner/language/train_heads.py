"""Train the slot heads: `python -m planner.language.train_heads SENTENCES.tsv`.

The threshold is chosen on sentences that the heads were not trained on. As the grammar knows most
words of these, it is made to forget one at a time: what it would then leave open is what the heads
will meet in sentences that nobody thought of.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional as F

from planner.command import COMMANDS
from planner.language.grammar import Parse, may_be_filled, openness, parse
from planner.language.lexicon import LEXICON
from planner.language.phrases import normalised
from planner.language.scoring import ASK_BACK, OUT_OF_SCOPE, Row, read_rows
from planner.language.sentence_encoder import embed
from planner.language.slot_heads import CLASSES, SHIPPED, SlotHeads, labels, save
from planner.language.templates import other_sentences, wordings

FOLDS = 10
PENALTY = 1e-4  # on the sum of squared weights; chosen by cross-validation
ITERATIONS = 100
OFTEN = 3  # a sentence of the set counts as so many made by rule
MAX_MISREAD = 0.01
MARGIN = 0.05  # of confidence, as unseen sentences are worse; assumed
UNKNOWN = "qqqq"
_vector = cache(embed)  # of all sentences, more than the encoder keeps
_CLOSED_SLOTS = {"refusal", "is", "too", "state", "after", "from", "particle", "preposition"}
_CLOSED_WORDS = {
    "too", "and", "both", "left", "right", "first", "second", "third", "last", "final", "one",
    "two", "three",
}  # fmt: skip


class GapInWords(NamedTuple):
    """A sentence of which the words say a part only, and what is expected of it."""

    row: Row
    parsed: Parse


class GapGuess(NamedTuple):
    """The likeliest command for a gap, where it may be taken."""

    row: Row
    openness: str
    text: str
    confidence: float

    @property
    def right(self) -> bool:
        """Whether it is what was expected, to the word: stricter than a score, for thresholds."""
        return self.text == self.row.expected


def mirrored(text: str) -> str:
    """With left for right and right for left."""
    swap = {"left": "right", "right": "left"}
    return " ".join(swap.get(word, word) for word in text.split())


def examples(rows: Sequence[Row]) -> list[Row]:
    """The sentences and their mirror images, and those made by rule."""
    said = [row for row in rows if row.expected != ASK_BACK] * OFTEN
    made = [Row(text, c.text) for c in COMMANDS.values() for text in wordings(c)]
    others = [Row(text, OUT_OF_SCOPE) for text in other_sentences()]
    sided = [row for row in said if not {"grasper", "scissors"} & set(row.sentence.split())]
    images = [Row(mirrored(row.sentence), mirrored(row.expected)) for row in sided]
    return [*said, *images, *made, *others]


def fit(rows: Sequence[Row]) -> dict[str, np.ndarray]:
    """The weights of each head (385, classes), by regularised maximum likelihood."""
    inside = [row for row in rows if row.expected != OUT_OF_SCOPE]
    weights = {}
    for head, names in CLASSES.items():
        of_head = rows if head == "in scope" else inside
        targets = torch.tensor([names.index(_label(row, head)) for row in of_head])
        weights[head] = _regress(_embeddings(of_head), targets, len(names)).numpy()
    return weights


def _label(row: Row, head: str) -> str:
    return "no" if row.expected == OUT_OF_SCOPE else labels(COMMANDS[row.expected])[head]


def _embeddings(rows: Sequence[Row]) -> Tensor:
    vectors = torch.stack([_vector(normalised(row.sentence)) for row in rows])
    return torch.cat([vectors, torch.ones(len(rows), 1)], dim=1)


def _regress(inputs: Tensor, targets: Tensor, n_classes: int) -> Tensor:
    """Softmax regression; the loss is convex, so that where it starts does not matter."""
    weights = torch.zeros(inputs.shape[1], n_classes, requires_grad=True)
    solver = torch.optim.LBFGS([weights], max_iter=ITERATIONS, line_search_fn="strong_wolfe")

    def loss() -> Tensor:
        solver.zero_grad()
        value = F.cross_entropy(inputs @ weights, targets) + PENALTY * weights[:-1].square().sum()
        value.backward()
        return value

    solver.step(loss)
    return weights.detach()


def gaps(rows: Sequence[Row]) -> Iterator[GapInWords]:
    """What the words leave open where the grammar does not know one of them."""
    for row in rows:
        words = normalised(row.sentence).split()
        texts = {" ".join([*words[:k], UNKNOWN, *words[k + 1 :]]) for k in _forgettable(words)}
        for text in sorted({row.sentence, *texts}):
            parsed = parse(text)
            if parsed.unknown and parsed.filled and not parsed.refusal:
                yield GapInWords(row, parsed)


def _forgettable(words: list[str]) -> list[int]:
    """Words that another person may say otherwise: all but the small closed classes."""
    closed = {phrase for phrase, sense in LEXICON.items() if sense.slot in _CLOSED_SLOTS}
    return [
        k for k, word in enumerate(words) if len(word) > 2 and word not in closed | _CLOSED_WORDS
    ]


def outcomes(rows: Sequence[Row]) -> list[GapGuess]:
    """What becomes of the gaps of rows that the heads were not trained on."""
    found = []
    for k in range(FOLDS):
        heads = SlotHeads(weights=fit(examples(_without(rows, k))), thresholds={})
        for row, parsed in gaps(rows[k::FOLDS]):
            ranked = heads.ranked(_vector(normalised(row.sentence)).numpy(), parsed.filled)
            if ranked and may_be_filled(parsed, ranked[0][1]):
                found.append(GapGuess(row, openness(parsed), ranked[0][1].text, ranked[0][0]))
    return found


def _without(rows: Sequence[Row], fold: int) -> list[Row]:
    return [row for k, row in enumerate(rows) if k % FOLDS != fold]


def chosen_thresholds(found: Sequence[GapGuess]) -> dict[str, float]:
    """By what is open, the least that `_threshold` allows."""
    kinds = sorted({one.openness for one in found})
    return {kind: _threshold([one for one in found if one.openness == kind]) for kind in kinds}


def _threshold(found: Sequence[GapGuess]) -> float:
    """The least at which no sentence out of scope moves the robot, and few are misread."""
    wrong = sorted((one.confidence for one in found if not one.right), reverse=True)
    outside = [one for one in found if one.row.expected == OUT_OF_SCOPE]
    moving = [one.confidence for one in outside if COMMANDS[one.text].moves]
    allowed = int(MAX_MISREAD * len(found))
    return max([MARGIN + c for c in (*wrong[allowed:][:1], *moving)], default=0.5)


def main() -> None:
    """Choose the thresholds by cross-validation, then train on all."""
    torch.set_num_threads(1)
    rows = read_rows(Path(sys.argv[1]))
    found = outcomes(rows)
    thresholds = chosen_thresholds(found)
    taken = [one.right for one in found if one.confidence >= thresholds[one.openness]]
    print(f"{len(found)} gaps; {thresholds}: {len(taken)} read, {sum(taken)} rightly")
    save(SHIPPED, SlotHeads(weights=fit(examples(rows)), thresholds=thresholds))


if __name__ == "__main__":
    main()
