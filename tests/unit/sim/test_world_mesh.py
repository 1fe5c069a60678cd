import math

import numpy as np
import pytest

from aos_sim.world.mesh import Material, concatenate, ellipsoid, perpendicular_axes, tubes, uniform_mesh
from aos_sim.world.person import Person, Posture, person_mesh


def make_person(posture: Posture = Posture.STANDING, heading_rad: float = 0.0, height_m: float = 1.75) -> Person:
    return Person("p", np.array([3.0, 7.0, 0.0]), heading_rad, height_m, posture, (200, 40, 40), 32.0, 26.0)


def test_tube_ends_have_their_radii() -> None:
    triangles = tubes([[0, 0, 1]], [[0, 0, 3]], [0.5], [0.25], sides=6)
    assert triangles.shape == (12, 3, 3)
    points = triangles.reshape(-1, 3)
    radius = np.hypot(points[:, 0], points[:, 1])
    np.testing.assert_allclose(radius[points[:, 2] == 1], 0.5, atol=1e-6)
    np.testing.assert_allclose(radius[points[:, 2] == 3], 0.25, atol=1e-6)


def test_ellipsoid_has_the_volume_of_its_semi_axes() -> None:
    a, b, c = np.moveaxis(ellipsoid((0, 0, 0), (1, 2, 3), segments=48, rings=32).astype(np.float64), 1, 0)
    volume = abs(np.einsum("ij,ij->i", a, np.cross(b, c)).sum()) / 6
    assert volume == pytest.approx(4 / 3 * math.pi * 6, rel=0.01)


def test_perpendicular_axes_are_orthonormal_also_for_vertical_directions() -> None:
    direction = np.vstack([np.random.default_rng(0).standard_normal((50, 3)), np.eye(3), -2 * np.eye(3)])
    first, second = perpendicular_axes(direction)
    for a, b, expected in [(first, first, 1), (second, second, 1), (first, second, 0)]:
        np.testing.assert_allclose(np.einsum("ij,ij->i", a, b), expected, atol=1e-12)
    np.testing.assert_allclose(np.einsum("ij,ij->i", first, direction), 0, atol=1e-12)
    np.testing.assert_allclose(np.einsum("ij,ij->i", second, direction), 0, atol=1e-12)


def test_concatenated_meshes_keep_their_order_and_properties() -> None:
    triangle = np.zeros((1, 3, 3), np.float32)
    bark = uniform_mesh(triangle, Material.BARK, (1, 2, 3), 10.0, 0.5)
    skin = uniform_mesh(triangle, Material.SKIN, (4, 5, 6), 32.0, 0.25)
    both = concatenate([bark, skin])
    assert both.material.tolist() == [Material.BARK, Material.SKIN]
    assert both.albedo_rgb.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert both.temperature_celsius.tolist() == [10, 32]
    assert both.sky_share.tolist() == [0.5, 0.25]
    assert len(concatenate([])) == 0


@pytest.mark.parametrize(
    ("posture", "top_m"), [(Posture.STANDING, 1.75), (Posture.SITTING, 0.94), (Posture.LYING, 0.28)]
)
def test_person_stands_on_the_ground_and_is_as_high_as_the_posture(posture: Posture, top_m: float) -> None:
    heights = person_mesh(make_person(posture)).triangles_enu_m[..., 2]
    assert heights.min() == pytest.approx(0.0, abs=0.03)
    assert heights.max() == pytest.approx(top_m, abs=0.03)


def test_lying_person_points_with_the_feet_to_the_heading() -> None:
    mesh = person_mesh(make_person(Posture.LYING, heading_rad=math.pi / 2))
    east = mesh.triangles_enu_m[..., 0]
    assert np.ptp(east) == pytest.approx(1.75, abs=0.05)
    assert east[mesh.material == Material.SKIN].min() == pytest.approx(3.0 - 1.75 / 2, abs=0.05)
    assert east[mesh.material == Material.CLOTHING].max() == pytest.approx(3.0 + 1.75 / 2, abs=0.05)


def test_sitting_person_has_the_knees_ahead() -> None:
    points = person_mesh(make_person(Posture.SITTING)).triangles_enu_m
    assert points[..., 1].max() > 7.0 + 0.5
    assert points[..., 1].min() > 7.0 - 0.3


def test_heading_turns_the_body_clockwise_and_keeps_its_shape() -> None:
    heading = 0.8
    north, turned = (person_mesh(make_person(Posture.SITTING, angle)).triangles_enu_m for angle in (0.0, heading))
    x, y = np.moveaxis(north[..., :2] - (3.0, 7.0), -1, 0)
    sin, cos = math.sin(heading), math.cos(heading)
    expected = np.stack([x * cos + y * sin + 3.0, y * cos - x * sin + 7.0, north[..., 2]], axis=-1)
    np.testing.assert_allclose(turned, expected, atol=1e-5)


def test_clothing_and_skin_carry_the_persons_temperatures_and_colour() -> None:
    mesh = person_mesh(make_person())
    assert set(mesh.temperature_celsius[mesh.material == Material.CLOTHING]) == {26.0}
    assert mesh.temperature_celsius[mesh.material == Material.SKIN].max() == 32.0
    jacket = mesh.albedo_rgb[(mesh.material == Material.CLOTHING) & (mesh.triangles_enu_m[..., 2].min(axis=1) > 1.0)]
    assert np.all(jacket == (200, 40, 40))
