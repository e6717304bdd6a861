"""Define the kinds of ligation clip: size, the vessels a kind is for, grip, and look.

A surgeon chooses the clip by the vessel. Metal clips have sizes for ranges of the vessel's width.
A medium one is for 2 to 4 mm, a medium-large one for 3.5 to 7 mm (Schenk et al., Innov. Surg. Sci.
1, 2016, p. 41-46). In 133 of 153 people, a metal clip of a 5 mm applier closed the cystic duct.
Ducts wider than 4.2 mm needed something else (Tabe et al., Cureus 2025). Numbers are assumed unless
a source stands beside them; no datasheet with a clip's width along the vessel was found.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class ClipKind:
    """One kind of clip.

    Attributes:
        name: Name, a key of `CLIPS`.
        material: What the legs are made of.
        width_m: Width along the vessel.
        length_m: Length of the closed legs.
        vessel_m: Least and largest outer diameter of a vessel that the kind is for.
        latch_gap_m: Distance of the legs' middles at which the clip stays closed.
        friction: Pull along the vessel over both legs' force, halved. It is friction on wet tissue
            and what tissue adds that bulges beside a narrow bar. Schenk et al. describe a "deep
            indentation of the metal bar with a high retention force".
        slides_n: Pull along the vessel that the kind never holds, whatever the grip.
        lock_strength_n: Pull across the vessel at which the clip opens.
        leg_thickness_m: Thickness of one leg in the closing direction.
        colour: Colour of the legs, linear RGB from 0 to 1.
        ribs: Ribs on the inside of each leg.
        locks: Whether the tips hook into each other; legs of metal stay bent.
    """

    name: str
    material: str
    width_m: float
    length_m: float
    vessel_m: tuple[float, float]
    latch_gap_m: float
    friction: float
    slides_n: float
    lock_strength_n: float
    leg_thickness_m: float
    colour: tuple[float, float, float]
    ribs: int
    locks: bool

    @property
    def bar_radius_m(self) -> float:
        """Return the radius of the closed clip as a bar; both legs are as thick as wide."""
        return 0.5 * self.width_m

    def fits(self, diameter_m: float) -> bool:
        """Return whether the kind is for a vessel of this outer diameter."""
        least, most = self.vessel_m
        return least <= diameter_m <= most


MEDIUM_TITANIUM, MEDIUM_LARGE_POLYMER = "medium titanium", "medium-large polymer"

CLIPS: dict[str, ClipKind] = {
    MEDIUM_TITANIUM: ClipKind(
        name=MEDIUM_TITANIUM,
        material="titanium",
        width_m=0.0010,
        length_m=0.0075,  # half the circumference of a vessel of 4 mm is 6.3 mm
        vessel_m=(0.0, 0.0040),  # Schenk et al.; thinner ones, too
        latch_gap_m=0.0012,
        friction=1.0,  # tissue beside the bar stands as a wedge of about 25 deg
        slides_n=4.5,  # 4.1 to 4.8 N along, on silicone (Arch. Surg. 127, 1992, p. 718)
        lock_strength_n=2.2,  # 1.8 to 2.7 N across, on silicone (the same)
        leg_thickness_m=0.0005,
        colour=(0.62, 0.62, 0.64),
        ribs=0,
        locks=False,
    ),
    MEDIUM_LARGE_POLYMER: ClipKind(
        name=MEDIUM_LARGE_POLYMER,
        material="polymer",
        width_m=0.0022,
        length_m=0.0095,
        vessel_m=(0.0030, 0.0100),  # Hem-o-lok ML, by its maker
        latch_gap_m=0.0016,
        friction=0.4,  # ribbed legs
        slides_n=50.0,  # no value was found; more than any pull here
        lock_strength_n=8.0,
        leg_thickness_m=0.00085,
        colour=(0.62, 0.55, 0.86),
        ribs=5,
        locks=True,
    ),
}
"""All kinds, the smallest first."""


def kind_for(diameter_m: float) -> ClipKind:
    """Return the smallest kind for a vessel of this outer diameter; the largest if none fits."""
    fitting = [kind for kind in CLIPS.values() if kind.fits(diameter_m)]
    return fitting[0] if fitting else list(CLIPS.values())[-1]
