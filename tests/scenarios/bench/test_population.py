"""Tests of the population bench: its tables show patients, studies, the rule and its grounds."""

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from scenarios.bench.operable import (
    LENGTHS,
    changed,
    fits,
    longer,
    of_same_rank,
    operable_share,
    reasons,
    reasons_table,
    sensitivity_table,
    with_widths,
)
from scenarios.bench.population import SHARES, drawn, population_table, studies_table
from scenarios.bench.population_plot import draw_size
from scenarios.cli import main
from tissue_sim.outcome.clip_rule import FEWEST_CLIPS, needed_m
from tissue_sim.outcome.room import why_call
from tissue_sim.patient.anatomy import anatomy_from_seed
from tissue_sim.patient.population import LAWS
from tissue_sim.patient.published import (
    DUCT_LENGTHS,
    LONGEST_M,
    PUBLISHED,
    SECOND_REVIEWS,
    SECOND_SERIES,
    SHORTEST_M,
    pooled_moments,
)
from tissue_sim.tools.instruments import appliers

PLOT = Path(__file__).parents[3] / "docs/anatomy.png"
BESIDE = 0.02  # a fitted law need not meet a share that it was not fitted to exactly


@pytest.fixture(scope="module")
def patients():
    return drawn(40_000, 3000)


def cells(table):
    return [list(column.cells) for column in table.columns]


def percent(cell: str) -> float:
    return float(cell.removesuffix(" %")) / 100


@pytest.mark.parametrize("title", SHARES)
def test_drawn_shares_are_the_published_ones(patients, title):
    low, high, has = SHARES[title]
    found = sum(map(has, patients)) / len(patients)
    sampling = 4.5 * math.sqrt(found * (1 - found) / len(patients))
    assert low - BESIDE - sampling < found < high + BESIDE + sampling


@pytest.mark.parametrize("name", PUBLISHED)
def test_drawn_sizes_have_the_mean_and_deviation_of_all_studies(patients, name):
    """Allow 4.5 standard errors, and what the rules between sizes change (0.03 deviations)."""
    mean, within, between = pooled_moments(PUBLISHED[name])
    sd = math.hypot(within, between)
    values = np.array([getattr(p, name) for p in patients])
    allowance = 4.5 / math.sqrt(len(patients)) + 0.03
    assert abs(values.mean() - mean) < allowance * sd
    assert abs(values.std() - sd) < allowance * sd


def test_the_table_tells_each_mean_as_published_and_as_drawn(patients):
    parameter, published, found = cells(population_table(patients))
    assert len(parameter) == len(PUBLISHED) + len(SHARES)
    row = parameter.index("duct length (mm)")
    mean_mm = 1e3 * sum(p.duct_length_m for p in patients) / len(patients)
    assert published[row] == "25 ± 11.4 (2 to 62)"
    assert found[row].startswith(f"{mean_mm:.3g} ± ")
    doubles = sum(p.second_artery is not None for p in patients)
    assert found[parameter.index("two arteries")] == f"{100 * doubles / len(patients):.1f} %"


def test_each_study_is_listed_with_what_is_assumed_and_each_pool_with_its_people():
    size, study, _, people, found = cells(studies_table())
    rows = list(zip(size, study, people, found, strict=True))
    assert ("duct length", "Shanmugam 2021", "100", "20.6 ± 11.4 (6 to 55)") in rows
    assert ("duct length", "Rajguru 2018", "100", "25* ± 12* (2 to 62)") in rows
    assert ("duct length", "pooled", "376", "25 ± 11.4") in rows
    pools = sum(len(studies) > 1 for studies in PUBLISHED.values())
    assert len(rows) == sum(map(len, PUBLISHED.values())) + pools


def test_the_rule_is_told_by_its_reasons_and_their_shares(patients):
    told, share, alone = cells(reasons_table(patients))
    assert told[0] == "operable"
    assert percent(share[0]) == pytest.approx(operable_share(patients), abs=5e-4)
    given = [reasons(p) for p in patients]
    for reason, part, only in zip(told[1:], share[1:], alone[1:], strict=True):
        assert percent(part) == pytest.approx(np.mean([reason in g for g in given]), abs=5e-4)
        assert percent(only) == pytest.approx(np.mean([g == (reason,) for g in given]), abs=5e-4)


def test_reasons_are_the_rules_sentences_without_the_patients_lengths(patients):
    for patient in patients[:300]:
        told = why_call(patient) or ""
        assert " ".join(reasons(patient)) == re.sub(r"\d+\.\d mm long", "too short", told)
        assert bool(reasons(patient)) == (why_call(patient) is not None)


def test_lengths_of_one_study_have_its_mean_and_leave_the_rest(patients):
    for tube, studies in LENGTHS.items():
        for study in studies:
            change = of_same_rank(study, studies)
            new = [changed(p, change, (tube,)) for p in patients[:1000]]
            lengths = np.array([getattr(p, f"{tube}_length_m") for p in new])
            spread = 4.5 * study.sd / math.sqrt(len(new))
            assert abs(lengths.mean() - study.mean) < spread
    patient = next(p for p in patients if p.second_artery)
    ducts = changed(patient, of_same_rank(DUCT_LENGTHS[0], DUCT_LENGTHS), ("duct",))
    assert replace(ducts, duct_length_m=patient.duct_length_m) == patient


def test_every_tube_becomes_longer_within_what_can_be_drawn(patients):
    patient = next(p for p in patients if p.second_artery)
    new = changed(patient, longer(0.001))
    assert new.duct_length_m == pytest.approx(patient.duct_length_m + 0.001)
    assert new.artery_length_m == pytest.approx(patient.artery_length_m + 0.001)
    assert new.second_artery.length_m == pytest.approx(patient.second_artery.length_m + 0.001)
    assert longer(1.0)(0.02) == LONGEST_M
    assert longer(-1.0)(0.02) == SHORTEST_M


def test_the_sensitivity_has_a_row_for_each_source_and_grows_with_the_room(patients):
    what, to, found = cells(sensitivity_table(patients[:600]))
    for tube, studies in LENGTHS.items():
        rows = [k for k, row in enumerate(what) if row == f"{tube} lengths"]
        assert [to[k].split(",")[0] for k in rows] == [s.name for s in studies]
        shares = {s.mean: percent(found[k]) for k, s in zip(rows, studies, strict=True)}
        assert shares[max(shares)] > shares[min(shares)]
    assert what.count("second arteries") == 1 + len(SECOND_REVIEWS) + len(SECOND_SERIES)
    room = [percent(found[k]) for k, row in enumerate(what) if row.startswith("room")]
    assert room == sorted(room)
    assert room[0] < percent(found[0]) < room[-1]
    for part in ("clip", "jaws"):
        for tool in appliers():
            rows = [
                k
                for k, row in enumerate(what)
                if row.startswith(f"{tool.in_words}: width of its {part}")
            ]
            wide, slim = (percent(found[k]) for k in rows)
            assert wide <= percent(found[0]) + 5e-4
            assert wide <= slim


def test_wider_clips_and_jaws_need_more_room_and_unchanged_ones_give_the_rule(patients):
    """Compare with lengths on either side of what wider jaws need; the clip counts likewise."""
    tools = {tool.name: tool for tool in appliers()}
    for patient in patients[:300]:
        assert fits(patient, tools) == (why_call(patient) is None)
    slim = with_widths(appliers()[0], jaws=1.25)
    wider_m = needed_m("artery", slim, FEWEST_CLIPS) - needed_m(
        "artery", appliers()[0], FEWEST_CLIPS
    )
    assert wider_m == pytest.approx(2 * 0.25 * appliers()[0].half_jaw_m)
    roomy = replace(
        patients[0],
        duct_length_m=0.03,
        artery_length_m=0.03,
        second_artery=None,
        artery_diameter_m=0.0015,
    )
    least_m = needed_m("artery", slim, FEWEST_CLIPS)
    wide = tools | {slim.name: slim}
    assert fits(replace(roomy, artery_length_m=least_m + 1e-6), wide)
    assert not fits(replace(roomy, artery_length_m=least_m - 1e-6), wide)
    assert fits(replace(roomy, artery_length_m=least_m - 1e-6), tools)


def test_patients_are_those_of_the_seeds(patients):
    assert patients[:3] == tuple(anatomy_from_seed(seed) for seed in (40_000, 40_001, 40_002))


@pytest.mark.parametrize("name", PUBLISHED)
def test_the_plotted_law_is_a_density_and_each_study_stands_at_its_mean(patients, name):
    axes = Figure().add_axes((0.0, 0.0, 1.0, 1.0))
    draw_size(axes, name, np.array([getattr(p, name) for p in patients]) * 1e3)
    law, *means = axes.get_lines()
    x, y = law.get_data()
    assert y.sum() * (x[1] - x[0]) == pytest.approx(1.0)
    assert 1e-3 * x[0] == pytest.approx(LAWS[name].low, rel=0.1)
    marks = [line.get_xdata()[0] for line in means]
    assert marks == pytest.approx([1e3 * s.mean for s in PUBLISHED[name]])
    assert [t.get_text().rsplit(" (")[0] for t in axes.texts] == [s.name for s in PUBLISHED[name]]


def test_the_command_prints_the_tables_and_plots_on_request(capsys, tmp_path):
    plot = tmp_path / "made here" / "plot.png"
    plot.parent.mkdir()
    assert main(["bench", "population", "--patients", "100", "--plot", str(plot)]) == 0
    told = capsys.readouterr().out
    for words in ("duct length (mm)", "Shanmugam 2021", "reason of a call", "second arteries"):
        assert words in told
    assert plot.read_bytes().startswith(b"\x89PNG")
    assert PLOT.stat().st_size < 150_000


def test_a_plot_that_cannot_be_written_is_refused_before_the_work(capsys, tmp_path):
    assert main(["bench", "population", "--plot", str(tmp_path)]) == 2
    assert "--plot" in capsys.readouterr().err
