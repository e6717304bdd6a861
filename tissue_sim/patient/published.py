"""State what is published about duct, artery and gallbladder: sizes, and shares of variants.

Each table lists the studies of one parameter. A study has a law, whose mean and standard deviation
after its cut are the study's. The pooled law mixes the studies' laws with their numbers of people
as weights. Its variance therefore is the variance within studies plus the variance between them.

Where a study reports no standard deviation, one of three assumptions replaces it:

- "range": the reported range over the expected range of so many normal draws (33: 4.17, 63: 4.68,
  82: 4.87, 100: 5.02);
- "error": the reported deviation is read as the mean's standard error, because it contradicts the
  study's own share of long ducts;
- "others": the deviation within the other studies of the table.

Most sources were read as abstracts. Reviews without a number of people are in `REVIEWS` and have no
weight.

The laws of lengths are not fitted to the reported shares of short tubes, because no abstract gives
the length below which a tube is short. These shares are beside the drawn ones in `calot bench
population`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from tissue_sim.patient.distributions import LogNormal, Mixture, Normal

MM = 1e-3
SHORTEST_M, LONGEST_M = 3 * MM, 55 * MM  # tubes that are drawn; see docs/physics.md, "Patients"
WIDEST_M = 6 * MM  # a clip of 9.5 mm spans no wider duct: flat, that is half its girth


@dataclass(frozen=True, kw_only=True)
class Study:
    """One study's measurement of a size, in m.

    Attributes:
        name: First author and year.
        measured: What was measured, and how.
        n: Number of people.
        mean: Mean.
        sd: Standard deviation.
        low: Smallest reported value; None if no range is reported.
        high: Largest reported value, likewise.
        law: Law with this mean and standard deviation, between the ends that are drawn.
        reference: Journal and page.
        assumed: What is not published: "mean", or the assumption of the standard deviation.
    """

    name: str
    measured: str
    n: int
    mean: float
    sd: float
    low: float | None = None
    high: float | None = None
    law: Normal | LogNormal
    reference: str
    assumed: tuple[str, ...] = ()


def pooled(studies: Sequence[Study]) -> Mixture:
    """Return the law of people from all studies together."""
    return Mixture(laws=tuple(s.law for s in studies), weights=tuple(float(s.n) for s in studies))


def pooled_moments(studies: Sequence[Study]) -> tuple[float, float, float]:
    """Return the mean of all people, and the deviations within and between studies, m."""
    n = sum(s.n for s in studies)
    mean = sum(s.n * s.mean for s in studies) / n
    within = sum(s.n * s.sd**2 for s in studies) / n
    between = sum(s.n * (s.mean - mean) ** 2 for s in studies) / n
    return mean, math.sqrt(within), math.sqrt(between)


SHANMUGAM = "Natl J Clin Anat 2021;10:155"
MARNIOK = "Med Sci Monit 1999;5:BR395"
SHERIFI = "Ital J Anat Embryol 2018;123:158"
SALDARRIAGA = "Int Arch Med, imedicalsociety.org 2830"
RAJGURU = "Int J Anat Radiol Surg 2018;7(2):AO23"
DANDEKAR = "Anat Res Int 2016;7201858"
TEJASWI = "Indian J Forensic Med Toxicol, i-scholar 52393"
CLIN_TER = "Clin Ter 2024;175:184"
ANDALL = "Surg Radiol Anat 2016;38:529"
TRIANTAFYLLOU = "Ann Anat 2025;257:152343"

# Rajguru & Dave report only a range: their mean is that of the other ducts. Their law is normal,
# because a log-normal law of this mean and deviation hardly reaches their shortest duct of 2 mm.
DUCT_LENGTHS: tuple[Study, ...] = (
    Study(
        name="Shanmugam 2021", measured="specimens", n=100, mean=20.6 * MM, sd=11.42 * MM,
        low=6 * MM, high=55 * MM, reference=SHANMUGAM,
        law=LogNormal(centre=17.395 * MM, spread=0.74809, low=6 * MM, high=55 * MM),
    ),
    Study(
        name="Marniok 1999", measured="specimens", n=80, mean=27.4 * MM, sd=11.0 * MM,
        reference=MARNIOK, assumed=("others",),
        law=LogNormal(centre=27.155 * MM, spread=0.49526, low=SHORTEST_M, high=LONGEST_M),
    ),
    Study(
        name="Sherifi 2018", measured="MRCP of patients", n=63, mean=27.3 * MM, sd=9.4 * MM,
        low=10 * MM, high=54 * MM, reference=SHERIFI, assumed=("range",),
        law=LogNormal(centre=26.274 * MM, spread=0.3885, low=10 * MM, high=54 * MM),
    ),
    Study(
        name="Saldarriaga", measured="injected blocks", n=33, mean=27.8 * MM, sd=9.2 * MM,
        reference=SALDARRIAGA, assumed=("error",),
        law=LogNormal(centre=26.823 * MM, spread=0.35874, low=SHORTEST_M, high=LONGEST_M),
    ),
    Study(
        name="Rajguru 2018", measured="specimens", n=100, mean=25.0 * MM, sd=12.0 * MM,
        low=2 * MM, high=62 * MM, reference=RAJGURU, assumed=("mean", "range"),
        law=Normal(centre=22.851 * MM, spread=15.087 * MM, low=SHORTEST_M, high=LONGEST_M),
    ),
)  # fmt: skip

ARTERY_LENGTHS: tuple[Study, ...] = (
    Study(
        name="Marniok 1999", measured="specimens, origin to fork", n=80, mean=27.1 * MM,
        sd=9.2 * MM, reference=MARNIOK, assumed=("others",),
        law=LogNormal(centre=26.042 * MM, spread=0.36552, low=SHORTEST_M, high=LONGEST_M),
    ),
    Study(
        name="Dandekar 2016", measured="cadavers", n=82, mean=16.9 * MM, sd=10.9 * MM,
        low=2 * MM, high=55 * MM, reference=DANDEKAR, assumed=("range",),
        law=LogNormal(centre=14.147 * MM, spread=0.74643, low=SHORTEST_M, high=LONGEST_M),
    ),
    Study(
        name="Tejaswi 2013", measured="specimens", n=100, mean=17.6 * MM, sd=7.6 * MM,
        low=3.7 * MM, high=42 * MM, reference=TEJASWI, assumed=("range",),
        law=LogNormal(centre=16.431 * MM, spread=0.46946, low=3.7 * MM, high=42 * MM),
    ),
)  # fmt: skip

# The low end of 1.5 mm is assumed: a law from 2 mm on cannot have these deviations. Rajguru's range
# would give 1.2 mm, which no law up to 6 mm with this mean can have; 1.05 mm.
DUCT_WIDTHS: tuple[Study, ...] = (
    Study(
        name="Marniok 1999", measured="specimens", n=80, mean=2.84 * MM, sd=0.85 * MM,
        reference=MARNIOK, assumed=("others",),
        law=LogNormal(centre=2.6619 * MM, spread=0.32394, low=1.5 * MM, high=WIDEST_M),
    ),
    Study(
        name="Sherifi 2018", measured="MRCP of patients", n=63, mean=3.2 * MM, sd=0.85 * MM,
        low=2 * MM, high=6 * MM, reference=SHERIFI, assumed=("range",),
        law=LogNormal(centre=2.8817 * MM, spread=0.33292, low=2 * MM, high=WIDEST_M),
    ),
    Study(
        name="Rajguru 2018", measured="specimens, in the middle", n=100, mean=3.0 * MM,
        sd=1.05 * MM, low=2 * MM, high=8 * MM, reference=RAJGURU, assumed=("mean", "deviation"),
        law=LogNormal(centre=2.6943 * MM, spread=0.46366, low=1.5 * MM, high=WIDEST_M),
    ),
)  # fmt: skip

# No study has arteries below 1 mm, and such an artery tears at less than the test pull of 1 N. No
# law from 1 mm on with these means can have the deviations that Tejaswi's ratio to the mean (0.2
# mm) or the range (0.8 mm) would give: Marniok 0.12 mm, Dandekar 0.5 mm.
ARTERY_WIDTHS: tuple[Study, ...] = (
    Study(
        name="Marniok 1999", measured="specimens", n=80, mean=1.17 * MM, sd=0.12 * MM,
        reference=MARNIOK, assumed=("deviation",),
        law=LogNormal(centre=1.1073 * MM, spread=0.13192, low=1 * MM, high=5 * MM),
    ),
    Study(
        name="Dandekar 2016", measured="cadavers", n=82, mean=1.6 * MM, sd=0.5 * MM,
        low=1 * MM, high=5 * MM, reference=DANDEKAR, assumed=("deviation",),
        law=LogNormal(centre=1.3247 * MM, spread=0.37694, low=1 * MM, high=5 * MM),
    ),
    Study(
        name="Tejaswi 2013", measured="specimens", n=100, mean=2.2 * MM, sd=0.42 * MM,
        low=1.1 * MM, high=3.2 * MM, reference=TEJASWI, assumed=("range",),
        law=LogNormal(centre=2.201 * MM, spread=0.21487, low=1.1 * MM, high=3.2 * MM),
    ),
)  # fmt: skip

# The range is that of another study: 100 cadavers, J Res Appl Basic Med Sci, March 2022. A sac
# below 45 mm by 18 mm cannot be meshed.
MANZOOR = "Int J Life Sci Biotechnol Pharma Res"
GALLBLADDER_LENGTHS: tuple[Study, ...] = (
    Study(
        name="Manzoor & Dar", measured="ultrasound", n=90, mean=75 * MM, sd=12 * MM, low=33 * MM,
        high=120 * MM, reference=MANZOOR,
        law=Normal(centre=74.73 * MM, spread=12.35 * MM, low=45 * MM, high=120 * MM),
    ),
)  # fmt: skip
GALLBLADDER_WIDTHS: tuple[Study, ...] = (
    Study(
        name="Manzoor & Dar", measured="ultrasound", n=90, mean=32 * MM, sd=8 * MM, low=20 * MM,
        high=50 * MM, reference=MANZOOR,
        law=Normal(centre=29.87 * MM, spread=11.61 * MM, low=18 * MM, high=50 * MM),
    ),
)  # fmt: skip

PUBLISHED: dict[str, tuple[Study, ...]] = {
    "gallbladder_length_m": GALLBLADDER_LENGTHS,
    "gallbladder_width_m": GALLBLADDER_WIDTHS,
    "duct_length_m": DUCT_LENGTHS,
    "duct_diameter_m": DUCT_WIDTHS,
    "artery_length_m": ARTERY_LENGTHS,
    "artery_diameter_m": ARTERY_WIDTHS,
}
"""The studies of each parameter of `Anatomy` that is drawn from what is published."""

REVIEWS: dict[str, tuple[tuple[str, float], ...]] = {  # without weight: (reference, mean in m)
    "duct_length_m": (("Priya 2022, Folia Morphol 82:498, 55 studies", 20 * MM),),
    "artery_length_m": (
        (f"{CLIN_TER}, 53 studies", 20.77 * MM),
        (f"{TRIANTAFYLLOU}, meta-analysis", 21.34 * MM),
    ),
    "artery_diameter_m": ((f"{CLIN_TER}, 53 studies", 1.91 * MM),),
}


# Shares of people with short tubes, two arteries or a node


@dataclass(frozen=True, kw_only=True)
class ReportedShare:
    """A reported share of people with some property; `n` is None if the number is unknown."""

    measured: str
    n: int | None
    share: float
    reference: str


def pooled_share(shares: Sequence[ReportedShare]) -> float:
    """Return the share of all people of the studies with a known number."""
    known = [(s.n, s.share) for s in shares if s.n is not None]
    return sum(n * share for n, share in known) / sum(n for n, _ in known)


SHORT_DUCTS: tuple[ReportedShare, ...] = (
    ReportedShare(measured="specimens", n=100, share=0.15, reference=SHANMUGAM),
    ReportedShare(measured="MRCP", n=198, share=0.01, reference="Radiol Res Pract 2016;3021484"),
    ReportedShare(measured="MRCP", n=290, share=0.003, reference="Iran J Med Sci (Shiraz)"),
    ReportedShare(measured="MRCP, under 10 mm", n=63, share=0.0, reference=SHERIFI),
    ReportedShare(
        measured="laparoscopies", n=65, share=0.092, reference="J Gandhara Med Dent Sci 2025"
    ),
)
SHORT_ARTERIES: tuple[ReportedShare, ...] = (
    ReportedShare(measured="review", n=1037, share=98 / 1037, reference=ANDALL),
    ReportedShare(measured="meta-analysis", n=None, share=0.20, reference=CLIN_TER),
    ReportedShare(
        measured="CT, right at the sac", n=256, share=11 / 256, reference="J Invest Surg 2019"
    ),
)

# The reviews contain most of the single series, so only the reviews are pooled. They overlap, too.
SECOND_REVIEWS: tuple[ReportedShare, ...] = (
    ReportedShare(measured="meta-analysis", n=10_071, share=0.13, reference=CLIN_TER),
    ReportedShare(measured="review", n=9800, share=0.089, reference=ANDALL),
    ReportedShare(measured="meta-analysis", n=None, share=0.114, reference=TRIANTAFYLLOU),
)
SECOND_SERIES: tuple[ReportedShare, ...] = (
    ReportedShare(
        measured="laparoscopies", n=600, share=0.122, reference="World J Gastroenterol 2007"
    ),
    ReportedShare(
        measured="laparoscopies", n=425, share=14 / 425, reference="Int J Health Clin Res 2020"
    ),
    ReportedShare(
        measured="laparoscopies", n=375, share=11 / 375, reference="J Minim Invasive Surg 2024"
    ),
    ReportedShare(measured="laparoscopies", n=360, share=11 / 360, reference="Int Surg J 2020"),
    ReportedShare(
        measured="laparoscopies", n=200, share=31 / 200, reference="World J Surg 1999;23:703"
    ),
    ReportedShare(measured="laparoscopies", n=200, share=21 / 200, reference="Al Helli, Karbala"),
    ReportedShare(measured="CT", n=73, share=20 / 73, reference="PubMed 25940813"),
    ReportedShare(measured="cadavers", n=200, share=3 / 200, reference="Int J Anat Var 2020;13"),
    ReportedShare(measured="casts", n=81, share=0.14, reference="Eur J Morphol 2003;41:31"),
    ReportedShare(measured="cadavers", n=82, share=0.28, reference=DANDEKAR),
)

NODES_SEEN: tuple[ReportedShare, ...] = (
    ReportedShare(measured="laparoscopies", n=217, share=170 / 217, reference="PubMed 27941745"),
    ReportedShare(
        measured="laparoscopies", n=393, share=0.817, reference="Surg Laparosc Endosc 2021;31:155"
    ),
)
"""The cystic node of Lund, seen during the dissection."""
