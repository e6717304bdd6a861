"""A report as one page of HTML that needs no network."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from scenarios.evaluation import published
from scenarios.evaluation.plots import ARMS, plots
from scenarios.evaluation.report import Report
from scenarios.evaluation.tables import tables
from scenarios.evaluation.words import counts, interval, rate
from scenarios.files.outside_text import templates
from scenarios.files.strict_json import dumps
from scenarios.loop.sensing_metrics import SPAN_S


def page(report: Report, made_with: Mapping[str, Any]) -> str:
    """Return the whole page; its links to recordings are paths in the report's folder."""
    template = templates(Path(__file__).parent).get_template("page.html.jinja")
    return template.render(
        report=report,
        colours={arm: f"arm{k % len(ARMS)}" for k, arm in enumerate(report.arms)},
        tables=tables(report),
        plots=plots(report),
        words={"counts": counts, "interval": interval, "rate": rate},
        source=published.SOURCE,
        span_s=SPAN_S,
        made_with=dumps(made_with, indent=2),
    )
