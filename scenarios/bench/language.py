"""Time the reading of free text on one thread, by grammar alone and with the sentence encoder."""

from __future__ import annotations

from time import perf_counter

import numpy as np
import torch
from rich.table import Table

from planner.command import COMMANDS
from planner.language.interpreter import Interpreter
from planner.language.sentence_encoder import embed

ALLOWED_MS = 30.0  # assumed: less than a control step
FRAMES = {"grammar": "could you {} please", "heads on embeddings": "could you {} forthwith"}
"""The last word of the second sentence is in no lexicon, so the encoder is used."""


def bench_language(repeats: int) -> Table:
    """Time the reading of every command, in one sentence for each way of reading."""
    torch.set_num_threads(1)
    interpreter = Interpreter()
    table = Table(title="text to reading, one thread")
    table.add_column("by")
    for heading in ("median (ms)", "p99 (ms)", "most (ms)", "allowed (ms)"):
        table.add_column(heading, justify="right")
    for by, frame in FRAMES.items():
        sentences = [frame.format(text) for text in COMMANDS]
        interpreter.read(sentences[0])  # loads what is loaded only once
        times_ms = [_time_ms(interpreter, said) for _ in range(repeats) for said in sentences]
        figures = (*np.percentile(times_ms, (50, 99)), max(times_ms), ALLOWED_MS)
        table.add_row(by, *(f"{figure:.2f}" for figure in figures))
    return table


def _time_ms(interpreter: Interpreter, sentence: str) -> float:
    embed.cache_clear()
    start_s = perf_counter()
    interpreter.read(sentence)
    return 1e3 * (perf_counter() - start_s)
