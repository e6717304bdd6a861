"""Plot the sizes of the drawn patients beside each published study."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tissue_sim.frames import Array
from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.patient.published import MM, PUBLISHED, Study, pooled

if TYPE_CHECKING:
    from matplotlib.axes import Axes

DRAWN, LAW, STUDY = "#9dc3d4", "#0f6b8f", "#c85a11"
BINS, POINTS = 40, 121
COLUMNS = ("duct", "artery", "gallbladder")


def save_plot(patients: Sequence[Anatomy], path: Path) -> None:
    """Draw a histogram of each size with its law and its studies, as a PNG."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 6.5), dpi=80, layout="constrained")
    axes = figure.subplots(2, len(COLUMNS))
    for column, part in zip(axes.T, COLUMNS, strict=True):
        for place, name in zip(column, [n for n in PUBLISHED if n.startswith(part)], strict=True):
            draw_size(place, name, np.array([getattr(p, name) for p in patients]) / MM)
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, frameon=False)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, format="png")


def draw_size(axes: Axes, name: str, values: Array) -> None:
    """Draw one size: the histogram, the law over it, and a line for each study above it.

    Args:
        axes: Where to draw.
        name: Parameter of `Anatomy`.
        values: (n_patient,), mm.
    """
    axes.hist(values, bins=BINS, density=True, color=DRAWN, label="drawn patients")
    law = pooled(PUBLISHED[name])
    ends = np.linspace(law.low, law.high, POINTS)
    density = np.diff([law.share(x) for x in ends.tolist()]) / np.diff(ends / MM)
    axes.plot(0.5 * (ends[1:] + ends[:-1]) / MM, density, color=LAW, lw=1.5, label="pooled law")
    top = max(float(density.max()), axes.get_ylim()[1])
    draw_studies(axes, PUBLISHED[name], top)
    title = name.removesuffix("_m").replace("_", " ")
    axes.set(title=f"{title} (mm)", yticks=[])
    axes.spines[["left", "right", "top"]].set_visible(False)


def draw_studies(axes: Axes, studies: Sequence[Study], top: float) -> None:
    """Draw each study as a line above the height `top`: mean, standard deviation and range."""
    right = axes.get_xlim()[1]
    for k, study in enumerate(studies):
        y, mean, sd = top * (1.1 + 0.14 * k), study.mean / MM, study.sd / MM
        label = "" if k else "study: mean, bold: standard deviation, thin: range"
        axes.hlines(y, mean - sd, mean + sd, color=STUDY, lw=4, label=label)
        if study.low is not None and study.high is not None:
            axes.hlines(y, study.low / MM, study.high / MM, color=STUDY, lw=1)
        axes.plot([mean], [y], "|", color=STUDY, ms=12, mew=2)
        axes.text(right, y, f"{study.name} ({study.n})", fontsize=7, ha="right", va="bottom")
    axes.set_ylim(0.0, top * (1.2 + 0.14 * len(studies)))
