"""A test of clear surfaces; it needs a renderer."""

import numpy as np
import pytest
import sapien

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


@pytest.mark.parametrize("clear", [0.0, 0.3, 0.7])
def test_a_clear_surface_lets_through_its_share_of_the_pixels_behind_it(clear: float) -> None:
    scene = renderable_scene()
    set_picture_formats()
    camera = sapien.render.RenderCameraComponent(160, 120, str(shader_pack()))
    camera.set_fovy(1.0, compute_x=True)
    camera.near, camera.far = 0.001, 1.0
    eye = sapien.Entity()
    eye.add_component(camera)
    scene.add_entity(eye)
    y, z = np.meshgrid(*[np.linspace(-0.5, 0.5, 5)] * 2)
    for away_m, share in ((0.2, 0.0), (0.1, clear)):  # the camera looks along x
        look = Look(colour=(0.5, 0.5, 0.5), clear=share)
        Drawn(scene, "sheet", look).show(sheet(np.stack([np.full_like(y, away_m), y, z], -1), 0.1))
    scene.update_render()
    camera.take_picture()
    assert camera.get_picture(COLOR_PICTURE)[..., :3].shape == (120, 160, 3)
    ahead_m = -1e-6 * camera.get_picture(POSITION_PICTURE)[..., 2]
    assert (ahead_m > 0.15).mean() == pytest.approx(clear, abs=0.02)
    np.testing.assert_allclose(np.minimum(abs(ahead_m - 0.1), abs(ahead_m - 0.2)), 0.0, atol=1e-4)
