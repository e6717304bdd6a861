"""Make materials: colour, wetness and a fine relief, as seamless procedural textures."""

from __future__ import annotations

from collections.abc import Sequence
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
REDDENING = np.array([0.7, 1.2, 1.4])  # assumed exponents: where tissue is darker it is redder
VESSEL = np.array([0.40, 0.035, 0.035])
VESSEL_RADIUS, VESSEL_END, VESSEL_TAPER = 1.2, 0.35, 0.994  # pixels: first, last; a pixel's change
BLURRED_RELIEF = 0.3  # assumed: share of the relief that the tissue under the film shows
DYE = (0.40, 0.015, 0.02)  # red, as in the video of SRT-H


@dataclass(frozen=True, kw_only=True)
class Look:
    """A material. Colours are linear RGB, 0 to 1; shares refer to the base colour.

    Attributes:
        mottle: Contrast of lighter and darker patches.
        vessels: Strength of the red of fine vessels.
        relief: Slope of the fine bumps.
        grain: Number of wavelengths of bumps and mottle in a tile.
        glow: Light that the surface emits.
        film: Share of the surface under clear liquid, whose small reflections follow the lamp.
        lobules: Slope of the lobules.
        lobule_contrast: Darkness of the seams between lobules.
        lobule_count: Number of lobules in a tile.
        dyed: Share of the surface under red liquid.
        clear: Share of the pixels through which what lies behind is seen.
    """

    colour: Colour
    roughness: float = 0.42
    specular: float = 0.5
    metallic: float = 0.0
    mottle: float = 0.0
    vessels: float = 0.0
    relief: float = 0.0
    grain: int = 12
    glow: float = 0.0
    film: float = 0.0
    lobules: float = 0.0
    lobule_contrast: float = 0.0
    lobule_count: int = 42
    dyed: float = 0.0
    clear: float = 0.0


@lru_cache(maxsize=64)  # materials of a few patients
def material(look: Look) -> sapien.render.RenderMaterial:
    """Return the renderer's material. The film's numbers are those of `shader_pack`."""
    made = _plain(look)
    if look.mottle or look.vessels or look.dyed or look.lobule_contrast:
        made.base_color_texture = _texture(colours(look), srgb=True)
    if look.relief:
        made.normal_texture = _texture(relief(look), pooled(), srgb=False)
    return made


def mixed(first: Colour, second: Colour, share: float) -> Colour:
    """Mix two colours; `share` is the second's."""
    red, green, blue = ((1.0 - share) * a + share * b for a, b in zip(first, second, strict=True))
    return red, green, blue


def painted(
    look: Look, places: Array, tints: Sequence[tuple[Colour, Array]]
) -> sapien.render.RenderMaterial:
    """Return a material whose texture is not tiled, so that colours may be laid on it.

    Args:
        look: The material under the colours.
        places: (rows, columns, 2) texture coordinates of the pixels in the tiled texture.
        tints: Colours, and their shares (rows, columns).
    """
    made = _plain(look)
    pixels = (np.round(SIZE * places).astype(int) % SIZE)[..., ::-1]
    row, column = pixels[..., 0], pixels[..., 1]
    colour = colours(look)[row, column]
    for tint, share in tints:
        shaded = np.array(tint) * (colour / np.array(look.colour)).mean(axis=-1, keepdims=True)
        colour = colour + share[..., None] * (shaded - colour)
    made.base_color_texture = _texture(colour, srgb=True)
    made.normal_texture = _texture(relief(look)[row, column], pooled()[row, column], srgb=False)
    return made


def _plain(look: Look) -> sapien.render.RenderMaterial:
    return sapien.render.RenderMaterial(
        base_color=[*look.colour, 1.0],
        roughness=look.roughness,
        specular=look.specular,
        metallic=look.metallic,
        emission=[*(look.glow * np.array(look.colour)), 1.0 - look.film],
        transmission=look.clear,
    )


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
def lobes(count: int, seed: int = 6, size: int = SIZE) -> Array:
    """Draw seamless cushions (size, size): 1 in the middle of each, 0 in the creases."""
    centres = np.random.default_rng([0x7E57, seed]).uniform(0, size, (count, 2))
    warp = 0.26 / np.sqrt(count) * size * np.stack([noise(1, 5, 7), noise(1, 5, 8)], axis=-1)
    tree = KDTree(centres, boxsize=size)
    distances = tree.query((_pixels(size) + warp) % size, k=2)[0].reshape(size, size, 2)
    near, far = distances[..., 0], distances[..., 1]
    return 1.0 - (2.0 * near / (near + far)) ** 2


@cache
def vessels(seed: int = 11, trunks: int = 4, size: int = SIZE) -> Array:
    """Draw seamless trees of fine vessels (size, size): 1 in the middle of a vessel, 0 outside."""
    rng = np.random.default_rng([0x7E57, seed])
    middles, headings = rng.uniform(0, size, (trunks, 2)), rng.uniform(0, np.pi, trunks)
    buds = [
        (at, way, VESSEL_RADIUS)
        for at, heading in zip(middles, headings, strict=True)
        for way in (heading, heading + np.pi)
    ]
    lines, radii = [], []
    while buds:
        at, heading, first = buds.pop()
        radius = first * VESSEL_TAPER ** np.arange(
            np.log(VESSEL_END / first) // np.log(VESSEL_TAPER)
        )
        way = heading + np.cumsum(rng.normal(0.0, 0.11, len(radius)))
        line = at + np.cumsum(np.stack([np.cos(way), np.sin(way)], axis=1), axis=0)
        lines.append(line)
        radii.append(radius)
        for k in np.flatnonzero(rng.random(len(radius)) < 0.035):  # the branch is the thinner one
            turn = rng.choice([-1.0, 1.0]) * rng.uniform(0.4, 1.0)
            buds.append((line[k], way[k] + turn, 0.7 * radius[k]))
    tree = KDTree(np.concatenate(lines) % size, boxsize=size)
    away, which = tree.query(_pixels(size), distance_upper_bound=VESSEL_RADIUS + 1.0)
    radius = np.append(np.concatenate(radii), 0.0)[which]
    return np.clip(radius + 0.5 - away, 0.0, 1.0) * np.clip(radius, 0.0, 1.0)


def _pixels(size: int) -> NDArray[np.int64]:
    return np.stack(np.meshgrid(*[np.arange(size)] * 2, indexing="ij"), axis=-1)


def colours(look: Look) -> Array:
    """Draw linear colours (size, size, 3)."""
    lightness = 1.0 + look.mottle * (0.6 * noise(1, 6, 1) + 0.4 * noise(6, look.grain * 4, 2))
    if look.lobule_contrast:
        lightness *= 1.0 - look.lobule_contrast * (1.0 - np.sqrt(lobes(look.lobule_count)))
    colour = np.array(look.colour) * np.clip(lightness, 0.3, 1.8)[..., None] ** REDDENING
    share = look.vessels * vessels()[..., None]
    colour = colour * (1 - share) + share * VESSEL
    return np.clip(np.where(_dyed(look.dyed)[..., None], DYE, colour), 0.0, 1.0)


def _dyed(share: float) -> NDArray[np.bool_]:
    """Return the places (size, size) of puddles that cover a share of the texture."""
    puddles = noise(1, 5, 9)
    return puddles >= np.quantile(puddles, 1.0 - share) if share else np.zeros(puddles.shape, bool)


def relief(look: Look) -> Array:
    """Draw normals (size, size, 3), coded as 0 to 1."""
    dx, dy = (look.relief * s for s in _slopes(noise(max(2, look.grain // 3), 3 * look.grain, 5)))
    if look.lobules:
        lx, ly = _slopes(lobes(look.lobule_count))
        dx, dy = dx + look.lobules * lx, dy + look.lobules * ly
    normals = np.stack([-dx, -dy, np.ones_like(dx)], axis=-1)
    return 0.5 + 0.5 * normals / np.linalg.norm(normals, axis=-1, keepdims=True)


@cache
def pooled() -> Array:
    """Draw the share (size, size) of the film that stays, 0 to 1; the film gathers in patches."""
    patches = 0.7 * noise(2, 12, 10) + 0.3 * noise(12, 40, 12)
    return np.clip(0.55 + 0.45 * patches, 0.05, 1.0)


def _slopes(height: Array) -> tuple[Array, Array]:
    """Return the slopes along x and y of a seamless relief, of unit spread."""
    dy, dx = (0.5 * (np.roll(height, -1, axis) - np.roll(height, 1, axis)) for axis in (0, 1))
    spread = np.hypot(dx.std(), dy.std())
    return dx / spread, dy / spread


def _texture(
    values: Array, alpha: Array | float = 1.0, *, srgb: bool
) -> sapien.render.RenderTexture2D:
    if srgb:
        values = np.clip(values, 0.0, 1.0) ** (1 / 2.2)
    fourth = np.broadcast_to(alpha, values.shape[:2])[..., None]
    values = 255 * np.concatenate([values, fourth], axis=-1)
    pixels: NDArray[np.uint8] = np.round(values).astype(np.uint8)
    return sapien.render.RenderTexture2D(pixels, format="r8g8b8a8unorm", mipmap_levels=5, srgb=srgb)
