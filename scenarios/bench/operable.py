"""How many drawn patients can be operated by the rule in force, and what does that rest on?

The rule is `why_call` of `tissue_sim.outcome.room`, which planner and judge share.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from rich.table import Table

from scenarios.files.outside_text import table_of
from tissue_sim.outcome.clip_rule import FEWEST_CLIPS, needed_m
from tissue_sim.outcome.room import why_call
from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.patient.population import SECOND_ARTERY_SHARE
from tissue_sim.patient.published import (
    ARTERY_LENGTHS,
    DUCT_LENGTHS,
    LONGEST_M,
    MM,
    SECOND_REVIEWS,
    SECOND_SERIES,
    SHORTEST_M,
    Study,
    pooled,
)
from tissue_sim.tools.instruments import Instrument, applier_for, appliers, clip_of

LENGTHS: dict[str, tuple[Study, ...]] = {"duct": DUCT_LENGTHS, "artery": ARTERY_LENGTHS}
SHIFTS_M = (-0.002, -0.001, 0.001, 0.002)  # how much longer all tubes are than drawn
FACTORS = (1.25, 0.8)  # on widths of clips and jaws


def operable_share(patients: Sequence[Anatomy]) -> float:
    """Return the share of patients for whom no person must be called; NaN without patients."""
    can = [why_call(patient) is None for patient in patients]
    return sum(can) / len(can) if can else float("nan")


def reasons(patient: Anatomy) -> tuple[str, ...]:
    """Return why a person must be called, a sentence each, without the patient's lengths."""
    told = why_call(patient) or ""
    sentences = re.split(r"(?<=\.) (?=[A-Z])", told) if told else []
    return tuple(re.sub(r"\d+\.\d+ mm long", "too short", text) for text in sentences)


def reasons_table(patients: Sequence[Anatomy]) -> Table:
    """Return the operable share and the share of each reason of a call, also as the only one."""
    given = [reasons(patient) for patient in patients]
    counts = Counter(reason for found in given for reason in found)
    alone = Counter(found[0] for found in given if len(found) == 1)
    n = len(patients)
    rows = [("operable", _percent(sum(not found for found in given) / n), "")]
    for reason, count in counts.most_common():
        rows.append((reason, _percent(count / n), _percent(alone[reason] / n)))
    return table_of(
        f"The rule on {n} patients", ("reason of a call",), ("share", "only reason"), rows
    )


def sensitivity_table(patients: Sequence[Anatomy]) -> Table:
    """Return the operable share with one source's law, share or length in place of the pooled."""
    rows = [
        ("as drawn", "", operable_share(patients)),
        *_single_studies(patients),
        *_second_shares(patients),
        *_shifts(patients),
        *_assumed_widths(patients),
    ]
    shown = [(what, source, _percent(share)) for what, source, share in rows]
    return table_of("What the operable share rests on", ("changed", "to"), ("operable",), shown)


def changed(
    patient: Anatomy, change: Callable[[float], float], tubes: Container[str] = LENGTHS
) -> Anatomy:
    """Return the patient with other lengths of "duct", of "artery" (all of them), or of both.

    Args:
        patient: The patient.
        change: Maps a length to the new one, m.
        tubes: Whose lengths change.
    """
    lengths: dict[str, Any] = {}
    if "duct" in tubes:
        lengths["duct_length_m"] = change(patient.duct_length_m)
    if "artery" in tubes:
        lengths["artery_length_m"] = change(patient.artery_length_m)
        if second := patient.second_artery:
            lengths["second_artery"] = replace(second, length_m=change(second.length_m))
    return replace(patient, **lengths)


def of_same_rank(study: Study, studies: Sequence[Study]) -> Callable[[float], float]:
    """Return the map from a length of the pooled law to the length of one study's law, m."""
    everyone = pooled(studies)
    return lambda length_m: study.law.value(everyone.share(length_m))


def longer(by_m: float) -> Callable[[float], float]:
    """Return the map to a length that is greater by this, within those that can be drawn, m."""
    return lambda length_m: min(max(length_m + by_m, SHORTEST_M), LONGEST_M)


def _single_studies(patients: Sequence[Anatomy]) -> Iterator[tuple[str, str, float]]:
    for tube, studies in LENGTHS.items():
        for study in studies:
            change = of_same_rank(study, studies)
            source = f"{study.name}, {study.mean / MM:.1f} ± {study.sd / MM:.1f} mm"
            share = operable_share([changed(p, change, (tube,)) for p in patients])
            yield f"{tube} lengths", source, share


def _second_shares(patients: Sequence[Anatomy]) -> Iterator[tuple[str, str, float]]:
    """Weigh patients with and without a second artery by each reported share."""
    two = operable_share([p for p in patients if p.second_artery is not None])
    one = operable_share([p for p in patients if p.second_artery is None])
    yield (
        "second arteries",
        f"{_percent(SECOND_ARTERY_SHARE)}: pooled",
        _mixed(two, one, SECOND_ARTERY_SHARE),
    )
    for found in (*SECOND_REVIEWS, *SECOND_SERIES):
        source = f"{_percent(found.share)}: {found.measured}, {found.reference}"
        yield "second arteries", source, _mixed(two, one, found.share)


def _shifts(patients: Sequence[Anatomy]) -> Iterator[tuple[str, str, float]]:
    """Lengthen all tubes: the same as clips, jaws and margins that need so much less."""
    for by_m in SHIFTS_M:
        share = operable_share([changed(p, longer(by_m)) for p in patients])
        need = f"{abs(by_m) / MM:.0f} mm {'less' if by_m > 0 else 'more'}"
        yield "room that a tube needs", need, share


def fits(patient: Anatomy, tools: Mapping[str, Instrument]) -> bool:
    """Return whether each tube has room for its clips, with these tools for those of that name."""
    sizes = {"duct": (patient.duct_length_m, patient.duct_diameter_m)}
    sizes |= {name: (a.length_m, a.diameter_m) for name, a in patient.arteries.items()}
    return all(
        length_m >= needed_m(tube, tools[applier_for(diameter_m).name], FEWEST_CLIPS)
        for tube, (length_m, diameter_m) in sizes.items()
    )


def with_widths(tool: Instrument, clip: float = 1.0, jaws: float = 1.0) -> Instrument:
    """Return an applier whose clip and whose jaws are wider by factors."""
    return replace(
        tool,
        clip=replace(clip_of(tool), width_m=clip * clip_of(tool).width_m),
        finger_half_width_m=jaws * tool.finger_half_width_m,
        finger_half_thickness_m=jaws * tool.finger_half_thickness_m,
    )


def _assumed_widths(patients: Sequence[Anatomy]) -> Iterator[tuple[str, str, float]]:
    """Change the width of each applier's clip and jaws; both are assumed."""
    tools = {tool.name: tool for tool in appliers()}
    for name, tool in tools.items():
        for part, width_m in (("clip", clip_of(tool).width_m), ("jaws", 2.0 * tool.half_jaw_m)):
            for factor in FACTORS:
                other = tools | {name: with_widths(tool, **{part: factor})}
                share = sum(fits(patient, other) for patient in patients) / len(patients)
                to = f"{factor * width_m / MM:.1f} mm, not {width_m / MM:.1f}"
                yield f"{tool.in_words}: width of its {part} (assumed)", to, share


def _mixed(first: float, second: float, share: float) -> float:
    return share * first + (1.0 - share) * second


def _percent(share: float) -> str:
    return f"{100 * share:.1f} %"
