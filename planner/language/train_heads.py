"""Train the slot heads: `python -m planner.language.train_heads SET.tsv ...`.

The threshold is chosen on sentences that the heads were not trained on. The grammar knows most
words of these, so it is made to forget one word at a time: this imitates sentences that nobody
thought of.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from functools import cache
from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional as F

from planner.command import COMMANDS
from planner.language.grammar import Parse, may_be_filled, openness, parse
from planner.language.lexicon import LEXICON
from planner.language.phrases import normalised
from planner.language.sentence_encoder import embed
from planner.language.sentence_sets import ASK_BACK, OUT_OF_SCOPE, Row, rows_named
from planner.language.slot_heads import CLASSES, SHIPPED, SlotHeads, in_words, labels, save
from planner.language.templates import other_sentences, wordings

FOLDS = 10
PENALTY = 1e-4  # on the sum of squared weights; chosen by cross-validation
ITERATIONS = 100
OFTEN = 3  # a sentence of the set counts as this many template sentences
MAX_MISREAD = 0.01
MARGIN = 0.05  # of confidence, because unseen sentences are harder; assumed
UNKNOWN = "qqqq"
_vector = cache(embed)  # keeps all sentences, more than the encoder's own cache
_CLOSED_SLOTS = {"refusal", "is", "too", "state", "after", "from", "particle", "preposition"}
_CLOSED_WORDS = {
    "too", "and", "both", "left", "right", "first", "second", "third", "last", "final", "one",
    "two", "three",
}  # fmt: skip


class GapInWords(NamedTuple):
    """A sentence whose words fill only a part of the slots, and its expected meaning."""

    row: Row
    parsed: Parse


class GapGuess(NamedTuple):
    """The likeliest command for a gap, if it may be guessed."""

    row: Row
    openness: str
    text: str
    confidence: float

    @property
    def right(self) -> bool:
        """Return whether the text is exactly the expected one; stricter than a score."""
        return self.text == self.row.expected


def mirrored(text: str) -> str:
    """Swap left and right."""
    swap = {"left": "right", "right": "left"}
    return " ".join(swap.get(word, word) for word in text.split())


def examples(rows: Sequence[Row]) -> list[Row]:
    """Return the sentences, their mirror images, and template sentences."""
    said = [row for row in rows if row.expected != ASK_BACK] * OFTEN
    made = [Row(text, c.text) for c in COMMANDS.values() for text in wordings(c)]
    others = [Row(text, OUT_OF_SCOPE) for text in other_sentences()]
    sided = [row for row in said if not {"grasper", "scissors"} & set(row.sentence.split())]
    images = [Row(mirrored(row.sentence), mirrored(row.expected)) for row in sided]
    return [*said, *images, *made, *others]


def fit(rows: Sequence[Row]) -> dict[str, np.ndarray]:
    """Fit the weights of each head (385, classes) by regularised maximum likelihood."""
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
    vectors = torch.stack([_vector(in_words(row.sentence)) for row in rows])
    return torch.cat([vectors, torch.ones(len(rows), 1)], dim=1)


def _regress(inputs: Tensor, targets: Tensor, n_classes: int) -> Tensor:
    """Fit a softmax regression; its loss is convex, so the start does not matter."""
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
    """Yield the parses of the sentences with one word forgotten that leave slots open."""
    for row in rows:
        words = normalised(row.sentence).split()
        texts = {" ".join([*words[:k], UNKNOWN, *words[k + 1 :]]) for k in _forgettable(words)}
        for text in sorted({row.sentence, *texts}):
            parsed = parse(text)
            if parsed.unknown and parsed.filled and not parsed.refusal:
                yield GapInWords(row, parsed)


def _forgettable(words: list[str]) -> list[int]:
    """Return the places of words that have synonyms: all but the small closed classes."""
    closed = {phrase for phrase, sense in LEXICON.items() if sense.slot in _CLOSED_SLOTS}
    return [
        k for k, word in enumerate(words) if len(word) > 2 and word not in closed | _CLOSED_WORDS
    ]


def outcomes(rows: Sequence[Row]) -> list[GapGuess]:
    """Return the guesses for the gaps of rows that the heads were not trained on."""
    found = []
    for k in range(FOLDS):
        heads = SlotHeads(weights=fit(examples(_without(rows, k))), thresholds={})
        for row, parsed in gaps(rows[k::FOLDS]):
            ranked = heads.ranked(_vector(in_words(row.sentence)).numpy(), parsed.filled)
            if ranked and may_be_filled(parsed, ranked[0][1]):
                found.append(GapGuess(row, openness(parsed), ranked[0][1].text, ranked[0][0]))
    return found


def _without(rows: Sequence[Row], fold: int) -> list[Row]:
    return [row for k, row in enumerate(rows) if k % FOLDS != fold]


def chosen_thresholds(found: Sequence[GapGuess]) -> dict[str, float]:
    """Return the lowest allowed threshold for each openness."""
    kinds = sorted({one.openness for one in found})
    return {kind: _threshold([one for one in found if one.openness == kind]) for kind in kinds}


def _threshold(found: Sequence[GapGuess]) -> float:
    """Return the lowest threshold at which no sentence out of scope moves, and few are misread."""
    wrong = sorted((one.confidence for one in found if not one.right), reverse=True)
    outside = [one for one in found if one.row.expected == OUT_OF_SCOPE]
    moving = [one.confidence for one in outside if COMMANDS[one.text].moves]
    allowed = int(MAX_MISREAD * len(found))
    return max([MARGIN + c for c in (*wrong[allowed:][:1], *moving)], default=0.5)


def main() -> None:
    """Choose the thresholds by cross-validation, then train on all."""
    rows = rows_named(sys.argv[1:], "planner.language.train_heads")
    torch.set_num_threads(1)
    found = outcomes(rows)
    thresholds = chosen_thresholds(found)
    taken = [one.right for one in found if one.confidence >= thresholds[one.openness]]
    print(f"{len(found)} gaps; {thresholds}: {len(taken)} read, {sum(taken)} rightly")
    save(SHIPPED, SlotHeads(weights=fit(examples(rows)), thresholds=thresholds))


if __name__ == "__main__":
    main()
