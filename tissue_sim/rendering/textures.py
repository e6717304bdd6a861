"""Materials: colour, wetness and a fine relief, as seamless procedural textures."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np
import sapien
from numpy.typing import NDArray
from scipy.spatial import KDTree

from tissue_sim.frames import Array

Colour = tuple[float, float, float]

SIZE = 256  # pixels of a texture's side
TILE_M = 0.030  # length of a texture's side on the tissue
DYE = (0.40, 0.015, 0.02)  # red, as in the video of SRT-H


@dataclass(frozen=True, kw_only=True)
class Look:
    """A material. Colours are linear RGB, 0 to 1; shares are of the base colour.

    Attributes:
        mottle: contrast of lighter and darker patches.
        vessels: strength of the red of fine vessels.
        relief: slope of the fine bumps.
        grain: number of wavelengths of bumps and mottle in a tile.
        glow: light that the surface emits.
        lobules: slope of the lobes of fat.
        dyed: share of the surface under red liquid.
    """

    colour: Colour
    roughness: float = 0.3
    specular: float = 0.6
    metallic: float = 0.0
    mottle: float = 0.0
    vessels: float = 0.0
    relief: float = 0.0
    grain: int = 12
    glow: float = 0.0
    lobules: float = 0.0
    dyed: float = 0.0


@lru_cache(maxsize=64)  # a few patients' worth
def material(look: Look) -> sapien.render.RenderMaterial:
    """Return the renderer's material."""
    made = sapien.render.RenderMaterial(
        base_color=[*look.colour, 1.0],
        roughness=look.roughness,
        specular=look.specular,
        metallic=look.metallic,
        emission=[*(look.glow * np.array(look.colour)), 1.0],
    )
    if look.mottle or look.vessels or look.dyed:
        made.base_color_texture = _texture(colours(look), srgb=True)
    if look.relief:
        made.normal_texture = _texture(relief(look), srgb=False)
    return made


@cache
def noise(low: int, high: int, seed: int, size: int = SIZE) -> Array:
    """Draw seamless noise (size, size) of unit spread, with wavelengths 1/low to 1/high tile."""
    rng = np.random.default_rng([0x7E57, seed])
    k = np.fft.fftfreq(size, 1.0 / size)
    radius = np.hypot(k[:, None], k[None])
    band = np.where((radius >= low) & (radius <= high), 1.0 / np.maximum(radius, 1.0), 0.0)
    spectrum = np.fft.fft2(rng.normal(size=(size, size))) * band
    field = np.fft.ifft2(spectrum).real
    return field / field.std()


@cache
def lobes(seed: int = 6, count: int = 42, size: int = SIZE) -> Array:
    """Draw seamless cushions (size, size): 1 in the middle of each, 0 in the creases."""
    centres = np.random.default_rng([0x7E57, seed]).uniform(0, size, (count, 2))
    pixels = np.stack(np.meshgrid(*[np.arange(size)] * 2, indexing="ij"), axis=-1)
    warp = 0.04 * size * np.stack([noise(1, 5, 7), noise(1, 5, 8)], axis=-1)
    tree = KDTree(centres, boxsize=size)
    distances = np.asarray(tree.query((pixels + warp) % size, k=2)[0]).reshape(size, size, 2)
    near, far = distances[..., 0], distances[..., 1]
    return 1.0 - (2.0 * near / (near + far)) ** 2


def colours(look: Look) -> Array:
    """Draw linear colours (size, size, 3)."""
    lightness = 1.0 + look.mottle * (0.6 * noise(1, 6, 1) + 0.4 * noise(6, look.grain * 4, 2))
    if look.lobules:
        lightness *= 0.70 + 0.30 * np.sqrt(lobes())
    colour = np.array(look.colour) * np.clip(lightness, 0.3, 1.8)[..., None]
    line = np.exp(-((noise(2, 9, 3) / 0.06) ** 2)) * np.clip(0.6 + 0.5 * noise(1, 4, 4), 0, 1)
    share = look.vessels * np.clip(line, 0.0, 1.0)[..., None]
    colour = colour * (1 - share) + share * np.array([0.36, 0.045, 0.04])
    return np.clip(np.where(_dyed(look.dyed)[..., None], DYE, colour), 0.0, 1.0)


def _dyed(share: float) -> NDArray[np.bool_]:
    """Return where puddles are (size, size) that cover a share of the texture."""
    puddles = noise(1, 5, 9)
    return puddles >= np.quantile(puddles, 1.0 - share) if share else np.zeros(puddles.shape, bool)


def relief(look: Look) -> Array:
    """Draw normals (size, size, 3), coded as 0 to 1."""
    dx, dy = (look.relief * s for s in _slopes(noise(max(2, look.grain // 3), 3 * look.grain, 5)))
    if look.lobules:
        lx, ly = _slopes(lobes())
        dx, dy = dx + look.lobules * lx, dy + look.lobules * ly
    normals = np.stack([-dx, -dy, np.ones_like(dx)], axis=-1)
    return 0.5 + 0.5 * normals / np.linalg.norm(normals, axis=-1, keepdims=True)


def _slopes(height: Array) -> tuple[Array, Array]:
    """Return the slopes along x and y of a seamless relief, of unit spread."""
    dy, dx = (0.5 * (np.roll(height, -1, axis) - np.roll(height, 1, axis)) for axis in (0, 1))
    spread = np.hypot(dx.std(), dy.std())
    return dx / spread, dy / spread


def _texture(values: Array, *, srgb: bool) -> sapien.render.RenderTexture2D:
    if srgb:
        values = np.clip(values, 0.0, 1.0) ** (1 / 2.2)
    opaque = np.concatenate([values, np.ones((*values.shape[:2], 1))], axis=-1)
    pixels: NDArray[np.uint8] = np.round(255 * opaque).astype(np.uint8)
    return sapien.render.RenderTexture2D(pixels, format="r8g8b8a8unorm", mipmap_levels=5, srgb=srgb)
