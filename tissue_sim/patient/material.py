"""Which material is the tissue made of? This file defines moduli by region.

Young's moduli are effective ones, for a mesh whose walls are thicker than the real ones. Shear
moduli of the walls are 85 +- 8 kPa (gallbladder), 166 +- 67 kPa (bile duct) and 210 +- 47 kPa
(hepatic artery). E is about 3 G. The source is Phys. Med. Biol. 64, 2019, 225001, table 1, a
collection of published values.

The moduli are scaled by real over meshed wall thickness. `WALL_THICKNESS_M` has the real
thicknesses. Meshed walls are 3.75 mm thick for the sac's body. Duct and artery walls are 0.7 and
0.5 mm thick. The common bile duct's wall is 1.5 mm thick, and the hepatic artery's 0.8 mm. Bile and
lumen are a soft fill: they carry the volume of the contents and keep opposite walls from passing
through each other.

A solid gallbladder differs from a hollow wall under bile pressure. The wall is not under tension at
rest. An opening therefore does not gape, and the sac does not become slack as it empties; only the
leak ends. The bile does not flow away from the jaws, so a pinch acts on the filling instead of two
walls in contact. A fold of wall cannot be lifted alone.

The gallbladder's wall is linear, while a real wall stiffens, and its stress at a given stretch is
not known. The wall therefore tears at a stretch and not at its strength (2.5 MPa, in the same
table). This material would reach that strength at a stretch of ten.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tissue_sim.frames import Array
from tissue_sim.patient.mesher import Indices

DENSITY_KG_M3 = 1000.0  # water


@dataclass(frozen=True, kw_only=True)
class Material:
    """Isotropic elasticity."""

    young_pa: float
    poisson: float

    @property
    def lame(self) -> tuple[float, float]:
        """Return mu and lambda of the fixed-corotated energy, Pa."""
        mu = self.young_pa / (2 * (1 + self.poisson))
        lam = self.young_pa * self.poisson / ((1 + self.poisson) * (1 - 2 * self.poisson))
        return mu, lam


MATERIALS = {
    "gallbladder wall": Material(young_pa=68e3, poisson=0.45),
    "bile": Material(young_pa=4e3, poisson=0.45),  # assumed
    "duct wall": Material(young_pa=285e3, poisson=0.45),
    "duct lumen": Material(young_pa=2e3, poisson=0.0),  # assumed
    "artery wall": Material(young_pa=500e3, poisson=0.45),
    "artery lumen": Material(young_pa=2e3, poisson=0.0),  # assumed
    "second artery wall": Material(young_pa=500e3, poisson=0.45),
    "second artery lumen": Material(young_pa=2e3, poisson=0.0),  # assumed
    "common bile duct wall": Material(young_pa=330e3, poisson=0.45),
    "common bile duct lumen": Material(young_pa=2e3, poisson=0.0),  # assumed
    "hepatic artery wall": Material(young_pa=470e3, poisson=0.45),
    "hepatic artery lumen": Material(young_pa=2e3, poisson=0.0),  # assumed
}

WALL_THICKNESS_M = {  # real, assumed
    "gallbladder": 1.0e-3,
    "duct": 0.4e-3,
    "artery": 0.4e-3,
    "second artery": 0.4e-3,
    "common bile duct": 1.0e-3,
    "hepatic artery": 0.6e-3,
}
SAC_MESH_WALL_M = 3.75e-3  # thickness for which the gallbladder wall's modulus is scaled

TIE_STIFFNESS = 400.0  # N/m per vertex, assumed: as stiff as the joined walls
TIE_STRENGTH = 1.5  # N per vertex, assumed
# The same per tied vertex of the ring at which a branch leaves its trunk. Three such vertices have
# the stiffness and strength of the thirteen vertices of a ring within the sac.
ROOT_STIFFNESS = 1740.0  # N/m, assumed
ROOT_STRENGTH = 6.5  # N, assumed
ANCHOR_STIFFNESS = 60.0  # N/m per vertex, assumed: loose connective tissue
ANCHOR_STRENGTH = 1.2  # N per vertex, assumed
# The hepatoduodenal ligament, per vertex at the back of a structure at risk. Assumed: a fold of
# peritoneum filled with fat, softer than the liver bed.
LIGAMENT_STIFFNESS = 16.0  # N/m
LIGAMENT_STRENGTH = 1.0  # N
REMNANT_STIFFNESS = 20.0  # N/m per strand, assumed
REMNANT_STRENGTH = 0.15  # N per strand, assumed


def lame_of(region: Indices, names: tuple[str, ...], scale: float) -> tuple[Array, Array]:
    """Return mu and lambda (n_tet,) of every tetrahedron, Pa, multiplied by `scale`."""
    table = np.array([MATERIALS[name].lame for name in names]) * scale
    return table[region, 0], table[region, 1]
