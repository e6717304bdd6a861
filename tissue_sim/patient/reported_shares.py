"""State the shares of people with short tubes, two arteries or a node that sources report.

The laws of lengths are not fitted to the shares of short tubes, because no abstract gives the
length below which a tube is short. These shares are beside the drawn ones in `calot bench
population`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from tissue_sim.patient.published import (
    ANDALL,
    CLIN_TER,
    DANDEKAR,
    SHANMUGAM,
    SHERIFI,
    TRIANTAFYLLOU,
)


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
