"""Whether a controller listens to words: each correction, and the tube that is not its turn."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from rich.table import Table

from planner.correction import CORRECTIONS
from scenarios.bench.trials.obedience_trial import Examination, ObedienceTrial, lost_trial
from scenarios.bench.trials.run_trials import TrialAttempt, run_all
from scenarios.files.wilson import wilson_interval
from scenarios.loop.episode_config import EpisodeConfig


def run_trials(config: EpisodeConfig, episodes: int, workers: int) -> list[ObedienceTrial]:
    """On the patients from the configuration's seed on, in order."""
    seeds = range(config.seed, config.seed + episodes)
    examination = TrialAttempt(run=Examination(config=config), lost=lost_trial)
    return sorted(run_all("words", seeds, workers, examination), key=lambda trial: trial.seed)


def obedience_table(trials: Sequence[ObedienceTrial]) -> Table:
    """Of each correction how often it was obeyed, and how often the wrong tube was gone to.

    And how often it was asked for and withheld, as `Told` has it: that counts as not obeyed.
    """
    told = [told for trial in trials for told in trial.told]
    given, obeyed = Counter(t.text for t in told), Counter(t.text for t in told if t.obeyed)
    withheld = Counter(t.text for t in told if t.withheld)
    table = Table(title=f"words obeyed, seeds {trials[0].seed} to {trials[-1].seed}")
    for heading in ("said", "times", "obeyed", "withheld", "share (95 % Wilson interval)"):
        table.add_column(heading, justify="left" if heading == "said" else "right")
    for correction in CORRECTIONS:
        text = correction.text
        _add(table, text, obeyed[text], given[text], str(withheld[text]))
    table.add_section()
    _add(table, "all corrections", obeyed.total(), given.total(), str(withheld.total()))
    tubes = [trial.wrong_tube for trial in trials if trial.wrong_tube is not None]
    _add(table, "to the tube whose turn it is not", sum(tubes), len(tubes))
    return table


def error_lines(trials: Sequence[ObedienceTrial]) -> list[str]:
    """A line for each trial that an error ended."""
    return [f"seed {trial.seed}: {trial.error}" for trial in trials if trial.error]


def _add(table: Table, said: str, obeyed: int, times: int, withheld: str = "") -> None:
    share = "never said" if times == 0 else _share(obeyed, times)
    table.add_row(said, str(times), str(obeyed), withheld, share)


def _share(obeyed: int, times: int) -> str:
    low, high = wilson_interval(obeyed, times)
    return f"{obeyed / times:.3f} ({low:.3f} to {high:.3f})"
