"""A report as one page of HTML that needs no network."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from scenarios.evaluation.page.arm_comparison import paired
from scenarios.evaluation.page.failures import failures
from scenarios.evaluation.page.foresight import foresight
from scenarios.evaluation.page.head import head
from scenarios.evaluation.page.ladders import ladders
from scenarios.evaluation.page.language import language
from scenarios.evaluation.page.parts import section
from scenarios.evaluation.page.pass_rates import conditions, pass_rates, times, which_patients
from scenarios.evaluation.page.senses import senses
from scenarios.evaluation.page.sheet import sheet
from scenarios.evaluation.page.srt_h import beside_srt_h
from scenarios.evaluation.page.thresholds import thresholds
from scenarios.evaluation.report import Report
from scenarios.files.outside_text import in_html
from scenarios.files.strict_json import dumps


def page(report: Report, made_with: Mapping[str, Any]) -> str:
    """Return the whole page; its links to recordings are paths in the report's folder."""
    sections = (
        pass_rates(report),
        paired(report),
        beside_srt_h(report),
        senses(report),
        ladders(report),
        conditions(report),
        which_patients(report),
        language(report),
        times(report),
        failures(report),
        thresholds(report),
        foresight(report),
        _made(made_with),
    )
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>Calot: evaluation</title><style>{sheet()}</style></head><body><main>"
        f"{head(report)}{''.join(sections)}</main></body></html>\n"
    )


def _made(made_with: Mapping[str, Any]) -> str:
    return section(
        "How it was made",
        "The same command on the same versions gives the same episodes, bit for bit, on one"
        " machine. All numbers of this page stand in results.json beside it.",
        f"<details><summary>Configuration and versions</summary><pre><code>"
        f"{in_html(dumps(made_with, indent=2))}</code></pre></details>",
    )
