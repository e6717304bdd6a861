"""Train the kind head: `python -m planner.language.train_kinds SET.tsv ...`; about 3 minutes."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence

import torch
from torch import Tensor
from torch.nn import functional as F
from torch.nn.utils.rnn import pad_sequence

from planner.language.kind_head import FROZEN, KINDS, in_words, kind_of, logits, save_weights
from planner.language.sentence_encoder import LAYERS, hidden_states, layer_weights
from planner.language.sentence_sets import Row, keeps_the_protocol, rows_named
from planner.learning.networks import one_thread

EPOCHS, BATCH, SEED = 8, 32, 0
LAYER_RATE, HEAD_RATE = 1e-4, 2e-3  # of learning; they fall to zero
WEIGHT_DECAY, DROPOUT = 0.01, 0.2


def trained(rows: Sequence[Row]) -> dict[str, Tensor]:
    """Return the weights of the last layers and of the head for sentences of the protocol.

    The same rows in the same order give the same weights, but for the rounding of the machine.
    """
    with one_thread():
        return _trained(rows)


def _trained(rows: Sequence[Row]) -> dict[str, Tensor]:
    torch.manual_seed(SEED)
    hidden = [hidden_states(in_words(row.said), FROZEN) for row in rows]
    kinds = torch.tensor([KINDS.index(kind_of(row.expected)) for row in rows])
    of_layers = layer_weights(range(FROZEN, LAYERS))
    of_head = {
        "head.weight": 0.02 * torch.randn(len(KINDS), hidden[0].shape[1]),
        "head.bias": torch.zeros(len(KINDS)),
    }
    weights = {name: w.requires_grad_() for name, w in (of_layers | of_head).items()}
    solver = torch.optim.AdamW(
        [
            {"params": list(of_layers.values()), "lr": LAYER_RATE},
            {"params": list(of_head.values()), "lr": HEAD_RATE},
        ],
        weight_decay=WEIGHT_DECAY,
    )
    steps = EPOCHS * -(-len(rows) // BATCH)
    falling = torch.optim.lr_scheduler.LambdaLR(solver, lambda k: 1.0 - k / steps)
    for batch in _batches(len(rows)):
        padded = pad_sequence([hidden[k] for k in batch], batch_first=True)
        mask = pad_sequence([torch.ones(len(hidden[k])) for k in batch], batch_first=True) > 0
        solver.zero_grad()
        found = logits(F.dropout(padded, DROPOUT), mask, weights)
        F.cross_entropy(found, kinds[batch]).backward()
        solver.step()
        falling.step()
    return {name: w.detach() for name, w in weights.items()}


def _batches(rows: int) -> Iterator[list[int]]:
    for _ in range(EPOCHS):
        for batch in torch.randperm(rows).split(BATCH):
            yield batch.tolist()


if __name__ == "__main__":
    named = rows_named(sys.argv[1:], "planner.language.train_kinds", keeps_the_protocol)
    save_weights(trained(named))
