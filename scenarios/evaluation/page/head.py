"""The page's head: the compared systems, and the pass rates."""

from __future__ import annotations

from scenarios.evaluation.arm import StudyArm
from scenarios.evaluation.page.sheet import N_COLOURS
from scenarios.evaluation.report import ArmReport, Report
from scenarios.evaluation.words import counts, interval, rate
from scenarios.files.outside_text import in_html
from scenarios.suites import Suite


def head(report: Report) -> str:
    first, last, n = report.seeds[0], report.seeds[-1], len(report.seeds)
    patients = (
        f"the patient of seed {first}" if n == 1 else f"{n} patients, seeds {first} to {last}"
    )
    suites = ", ".join(suite.name for suite in report.suites)
    headline = report.headline
    cards = "".join(_card(k, found, headline) for k, found in enumerate(report.arms.values()))
    return (
        f"<h1>How often does it succeed?</h1><p class='lead'>Every arm met the same {patients}, in"
        f" {in_html(suites)}. The gallbladder is grabbed, either tube gets two or three clips and a"
        " cut. A procedure passes when all is done, every clip holds a test pull, nothing leaks"
        f" and nothing is injured.</p><div class='cards'>{cards}</div>"
    )


def _card(k: int, found: ArmReport, headline: Suite | None) -> str:
    passed = "" if headline is None else _passed(headline.name, found)
    return (
        f"<div class='card arm{k % N_COLOURS}'><h3>{in_html(found.arm.name)}</h3>"
        f"<span class='soft'>{in_html(_stack(found.arm))}</span>{passed}</div>"
    )


def _passed(suite: str, found: ArmReport) -> str:
    summary = found.suites[suite].summary
    return (
        f"<b>{rate(summary.pass_rate)}</b><span class='soft'>{counts(summary)} in"
        f" {in_html(suite)}, 95 % interval {interval(summary.wilson_95, 0, 100.0)} %</span>"
    )


def _stack(arm: StudyArm) -> str:
    """Return the parts of a system in words."""
    parts = [f"{arm.planner} planner, {arm.controller} controller", f"sense {arm.sense}"]
    parts += [] if arm.safety_filter else ["no safety filter"]
    parts += [arm.ablation] if arm.ablation else []
    parts += [f"a scripted {arm.person} corrects"] if arm.person else []
    return ", ".join(parts)
