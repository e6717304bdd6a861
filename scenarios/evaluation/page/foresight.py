"""The section on the planner's prediction of failure."""

from __future__ import annotations

from collections.abc import Sequence

from scenarios.evaluation.detection import Alarm, Detection, Share
from scenarios.evaluation.page.parts import arm_name, section, table
from scenarios.evaluation.page.plots import roc
from scenarios.evaluation.page.sheet import N_COLOURS
from scenarios.evaluation.report import Report
from scenarios.evaluation.words import NOTHING, number


def foresight(report: Report) -> str:
    told = [
        (k, arm, found.detection)
        for k, (arm, found) in enumerate(report.arms.items())
        if found.detection is not None
    ]
    curves = [(k % N_COLOURS, d.roc) for k, _, d in told if d.roc_auc is not None]
    rows = [(arm_name(k, arm), *_detected(d)) for k, arm, d in told]
    head = ("arm", "passed, failed", "ROC AUC", "own alarm: caught", "false", "lead (s)",
            "conformal alarm: caught", "false")  # fmt: skip
    return section(
        "Does the planner see failure coming?",
        "An episode is scored by the highest chance of failure that its planner gave (SAFE, arXiv"
        " 2506.09937). The planner's own alarm is calibrated for single tasks, the conformal one on"
        " every other passed episode, so that at most 5 % of the passes raise one.",
        (roc(curves) if curves else "") + table(head, 1, rows) if told else "",
    )


def _detected(found: Detection) -> Sequence[str]:
    own, conformal = found.own, found.conformal
    return (
        f"{found.passed}, {found.failed}",
        number(found.roc_auc, 3),
        *_alarm(own),
        number(own.lead_s, 1),
        *(_alarm(conformal) if conformal else (NOTHING, NOTHING)),
    )


def _alarm(alarm: Alarm) -> tuple[str, str]:
    return _share(alarm.caught), _share(alarm.false)


def _share(share: Share) -> str:
    return f"{share.count} of {share.of}"
