"""Tests of the shaders: clear surfaces, shadows, vignette; they need a renderer."""

import numpy as np
import pytest
import sapien
from numpy.typing import NDArray

from tissue_sim.frames import Array
from tissue_sim.rendering.drawing import Drawn
from tissue_sim.rendering.renderer import renderer_available
from tissue_sim.rendering.shader_pack import (
    COLOR_PICTURE,
    POSITION_PICTURE,
    set_picture_formats,
    shader_pack,
)
from tissue_sim.rendering.shapes import sheet
from tissue_sim.rendering.textures import Look
from tissue_sim.rendering.view import renderable_scene

pytestmark = [
    pytest.mark.render,
    pytest.mark.skipif(not renderer_available(), reason="SAPIEN finds no Vulkan renderer here"),
]
HEIGHT, WIDTH = 120, 160
GREY = Look(colour=(0.3, 0.3, 0.3), roughness=0.9, specular=0.0)


class Stage:
    """A camera at the world's origin that looks along x, with one lamp and square plates."""

    def __init__(self, lamp_m: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> None:
        self.scene = renderable_scene()
        set_picture_formats()
        self._camera = sapien.render.RenderCameraComponent(WIDTH, HEIGHT, str(shader_pack()))
        self._camera.set_fovy(1.0, compute_x=True)
        self._camera.near, self._camera.far = 0.001, 1.0
        light = sapien.render.RenderPointLightComponent()
        light.shadow, light.color = False, [0.03, 0.03, 0.03]
        for component in (self._camera, light):
            entity = sapien.Entity()
            entity.add_component(component)
            self.scene.add_entity(entity)
        light.entity.set_pose(sapien.Pose(list(lamp_m)))

    def plate(self, away_m: float, half_m: float, look: Look = GREY, up_m: float = 0.0) -> None:
        y, z = np.meshgrid(*[np.linspace(-half_m, half_m, 5)] * 2)
        points = np.stack([np.full_like(y, away_m), y, z + up_m], axis=-1)
        Drawn(self.scene, "plate", look).show(sheet(points, 0.1))

    def picture(self, kind: str) -> NDArray:
        self.scene.update_render()
        self._camera.take_picture()
        return self._camera.get_picture(kind)

    def light(self) -> Array:
        return self.picture(COLOR_PICTURE)[..., 1].astype(float)


@pytest.mark.parametrize("clear", [0.0, 0.3, 0.7])
def test_a_clear_surface_lets_through_its_share_of_the_pixels_behind_it(clear: float) -> None:
    stage = Stage()
    stage.plate(0.2, 0.5)
    stage.plate(0.1, 0.5, Look(colour=(0.5, 0.5, 0.5), clear=clear))
    ahead_m = -1e-6 * stage.picture(POSITION_PICTURE)[..., 2]
    assert (ahead_m > 0.15).mean() == pytest.approx(clear, abs=0.02)
    np.testing.assert_allclose(np.minimum(abs(ahead_m - 0.1), abs(ahead_m - 0.2)), 0.0, atol=1e-4)


def test_a_plate_casts_a_shadow_away_from_the_lamp_and_none_towards_it() -> None:
    """The lamp is above the camera, so the shadow shows below the plate."""
    bare, covered = Stage((0.0, 0.0, 0.08)), Stage((0.0, 0.0, 0.08))
    for stage in (bare, covered):
        stage.plate(0.1, 0.5)
    covered.plate(0.096, 0.010)
    darker = covered.light() / bare.light()
    focal_px = 0.5 * HEIGHT / np.tan(0.5)
    edge = round(focal_px * 0.010 / 0.096)
    middle, column = HEIGHT // 2, WIDTH // 2
    below = darker[middle + edge + 1 : middle + edge + 3, column - 3 : column + 3].mean()
    above = darker[middle - edge - 3 : middle - edge - 1, column - 3 : column + 3].mean()
    assert below < 0.85
    assert above == pytest.approx(1.0, abs=0.02)
    far = darker[:10]
    assert far.mean() == pytest.approx(1.0, abs=0.01)


def test_the_picture_darkens_towards_its_corners() -> None:
    stage = Stage()
    stage.scene.render_system.ambient_light = np.ones(3)  # pyright: ignore
    stage.plate(0.05, 0.5, Look(colour=(0.2, 0.2, 0.2), specular=0.0, roughness=1.0))
    light = stage.light()
    corner, middle = light[:4, :4].mean(), light[58:62, 78:82].mean()
    assert 0.2 < corner / middle < 0.5
