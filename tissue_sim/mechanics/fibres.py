"""Compute the collagen fibres in a wall, which carry load only when stretched, and then stiffen.

    psi(F) = c / 4 (s - 1)^4  for s > 1, else 0,      s = |F A|

with the fibres' direction A at rest. Fibres that act in tension alone are from Holzapfel, Gasser
and Ogden, "A new constitutive framework for arterial wall mechanics", 2000. Here the law is a
power, because their exponential overflows in a step that overshoots. A crushed lumen does not
stiffen: its wall is pressed and bent but not stretched along the tube.
"""

from __future__ import annotations

import warp as wp

wp.set_module_options({"enable_backward": False})


@wp.func
def fibre_stress(F: wp.mat33, along: wp.vec3, c: float):
    """Return the fibres' first Piola-Kirchhoff stress, in the unit of c."""
    drawn = F * along
    stretch = wp.length(drawn)
    over = stretch - 1.0
    if over <= 0.0:
        return wp.mat33()
    tension = c * over * over * over / stretch
    return wp.outer(drawn * tension, along * 1.0)


@wp.func
def fibre_stiffness(F: wp.mat33, along: wp.vec3, c: float):
    """Return M such that the block of corners with rest gradients g and h is (g.A) (h.A) M."""
    drawn = F * along
    stretch = wp.length(drawn)
    over = stretch - 1.0
    if over <= 0.0:
        return wp.mat33()
    n = drawn / stretch
    tension = c * over * over * over / stretch
    slope = 3.0 * c * over * over
    return wp.identity(n=3, dtype=float) * tension + wp.outer(n, n) * (slope - tension)


@wp.func
def fibre_energy(F: wp.mat33, along: wp.vec3, c: float):
    """Return psi, in the unit of c."""
    over = wp.max(wp.length(F * along) - 1.0, 0.0)
    return 0.25 * c * over * over * over * over
