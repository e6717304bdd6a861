"""Check whether the controller obeys each correction, and the order to clip the other tube."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from rich.table import Table

from planner.correction import CORRECTIONS
from scenarios.bench.trials.obedience_trial import ObedienceTrial
from scenarios.files.outside_text import table_of
from scenarios.loop.results import wilson_interval


def obedience_table(trials: Sequence[ObedienceTrial]) -> Table:
    """Return how often each correction was obeyed, and how often the instructed tube was chosen.

    A correction that was withheld (see `CorrectionResponse`) counts as not obeyed.
    """
    responses = [response for trial in trials for response in trial.responses]
    given, obeyed = (
        Counter(r.text for r in responses),
        Counter(r.text for r in responses if r.obeyed),
    )
    withheld = Counter(r.text for r in responses if r.withheld)
    title = f"words obeyed, seeds {trials[0].seed} to {trials[-1].seed}"
    figures = ("times", "obeyed", "withheld", "share (95 % Wilson interval)")
    table = table_of(title, ("said",), figures, ())
    for correction in CORRECTIONS:
        text = correction.text
        _add(table, text, obeyed[text], given[text], str(withheld[text]))
    table.add_section()
    _add(table, "all corrections", obeyed.total(), given.total(), str(withheld.total()))
    tubes = [trial.wrong_tube for trial in trials if trial.wrong_tube is not None]
    _add(table, "to the tube whose turn it is not", sum(tubes), len(tubes))
    return table


def _add(table: Table, said: str, obeyed: int, times: int, withheld: str = "") -> None:
    share = "never said" if times == 0 else _share(obeyed, times)
    table.add_row(said, str(times), str(obeyed), withheld, share)


def _share(obeyed: int, times: int) -> str:
    low, high = wilson_interval(obeyed, times)
    return f"{obeyed / times:.3f} ({low:.3f} to {high:.3f})"
