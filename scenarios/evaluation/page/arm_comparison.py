"""The section that compares each system with the first, patient by patient."""

from __future__ import annotations

from collections.abc import Iterator

from scenarios.evaluation.comparison import ArmComparison
from scenarios.evaluation.page.parts import arm_name, section, table
from scenarios.evaluation.report import Report
from scenarios.evaluation.words import NOTHING, interval, signed
from scenarios.files.outside_text import in_html

MEASURED = {
    "time_s": ("time (s)", 1.0, 1),
    "path_m": ("path (mm)", 1e3, 0),
    "jerk_m": ("jerk (µm/step³)", 1e6, 1),
    "corrections": ("corrections", 1.0, 1),
    "clearance_m": ("clearance (mm)", 1e3, 2),
}
"""Heading, scale and decimals of each measure that is compared where both pass."""


def paired(report: Report) -> str:
    colours = {arm: k for k, arm in enumerate(report.arms)}
    rows = [
        (
            arm_name(colours[c.arm], c.arm),
            in_html(c.suite),
            str(c.pairs),
            str(c.only_arm),
            str(c.only_reference),
            f"{signed(c.difference, 0, 100.0)} %",
            f"{interval(c.tango_95, 0, 100.0)} %",
            f"{c.mcnemar_p:.3g}",
        )
        for c in report.comparisons
    ]
    apart = [
        (arm_name(colours[c.arm], c.arm), in_html(c.suite), *_apart(c))
        for c in report.comparisons
        if c.where_both_pass
    ]
    reference = next(iter(report.arms))
    head = ("arm", "suite", "pairs", "only it passes", f"only {reference}", "difference",
            "95 % interval", "McNemar p")  # fmt: skip
    tables = table(tuple(map(in_html, head)), 2, rows)
    if apart:
        tables += "<h3 style='margin-top:22px'>Where both pass</h3>"
        tables += table(("arm", "suite", *(name for name, *_ in MEASURED.values())), 2, apart)
    return section(
        f"Against {in_html(reference)}, patient by patient",
        "Each arm minus the first on the same anatomies. The p-value is McNemar's, exact; the"
        " interval of a difference of rates is Tango's (1998), that of other means Student's."
        " P-values are not corrected for how many comparisons there are, and conditions of a suite"
        " share their patients.",
        tables if rows else "",
    )


def _apart(comparison: ArmComparison) -> Iterator[str]:
    """Yield a cell for each measure: the mean difference, and its interval below."""
    found = {difference.measure: difference for difference in comparison.where_both_pass}
    for measure, (_, scale, digits) in MEASURED.items():
        if (d := found.get(measure)) is None:
            yield NOTHING
        else:
            ends = interval(d.interval_95, digits, scale)
            yield f"{signed(d.mean, digits, scale)}<br><span class='soft'>{ends}</span>"
