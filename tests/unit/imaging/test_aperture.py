import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.imaging.aperture import (
    footprint_m,
    integral_visibility,
    packed_aperture_m,
    plan_aperture,
    samples_for,
    seen_at_least_once,
    smallest_spacing_m,
)
from aos_gcs.planning.settings import FlightSettings
from aos_sim.render import Renderer
from aos_sim.render.raycaster import RayCaster
from aos_sim.world.scene import SceneParameters, build_scene
from tests.fakes.command_line import exit_status
from tests.fakes.visibility import person_visibility

FOREST = {
    "altitude_m": 35.0,
    "fov_rad": math.radians(50.0),
    "canopy_height_m": 18.0,
    "crown_base_m": 6.0,
    "occluder_size_m": 1.0,
    "occlusion": 0.85,
}

SHARES = st.floats(0.0, 1.0)


@given(
    altitude_m=st.floats(20.0, 100.0),
    height_m=st.floats(1.0, 19.0),
    size_m=st.floats(0.05, 3.0),
    east_m=st.floats(-20.0, 20.0),
)
def test_at_the_smallest_spacing_shadows_of_an_occluder_touch(
    altitude_m: float, height_m: float, size_m: float, east_m: float
) -> None:
    def shadow(camera_m: float) -> list[float]:
        edges = np.array([east_m - size_m / 2, east_m + size_m / 2])
        return list(camera_m + (edges - camera_m) * altitude_m / (altitude_m - height_m))

    spacing_m = smallest_spacing_m(altitude_m, height_m, size_m)
    assert shadow(0.0)[0] == pytest.approx(shadow(spacing_m)[1], abs=1e-6 * altitude_m)


@given(occlusion=SHARES)
def test_ten_samples_reach_95_percent_in_any_forest(occlusion: float) -> None:
    assert samples_for(occlusion, 0.95) <= 10
    if occlusion < 1.0:
        assert integral_visibility(occlusion, 10) >= 0.95 * integral_visibility(occlusion, math.inf) - 1e-12


@given(occlusion=st.floats(0.01, 0.99), saturation=st.floats(0.0, 0.99))
def test_the_number_of_samples_is_the_smallest_that_is_enough(occlusion: float, saturation: float) -> None:
    enough = samples_for(occlusion, saturation)
    limit = integral_visibility(occlusion, math.inf)
    assert integral_visibility(occlusion, enough) >= saturation * limit - 1e-6
    if enough > 1:
        assert integral_visibility(occlusion, enough - 1) < saturation * limit + 1e-6


@given(occlusion=SHARES, samples=st.integers(1, 50))
def test_visibility_grows_with_samples_and_falls_with_correlation(occlusion: float, samples: int) -> None:
    visibility = integral_visibility(occlusion, samples)
    assert 1.0 - occlusion <= visibility + 1e-12
    assert visibility <= integral_visibility(occlusion, samples + 1) + 1e-12
    assert integral_visibility(occlusion, samples, correlation=0.3) <= visibility + 1e-12
    assert integral_visibility(occlusion, samples, correlation=1.0) == pytest.approx(1.0 - occlusion)
    assert seen_at_least_once(occlusion, samples) <= seen_at_least_once(occlusion, samples + 1)


def test_the_model_holds_for_occluders_at_random() -> None:
    free = np.random.default_rng(0).random((20_000, 10)) > 0.7
    assert 1.0 - np.mean((1.0 - free.mean(axis=1)) ** 2) == pytest.approx(integral_visibility(0.7, 10), abs=0.01)
    assert free.any(axis=1).mean() == pytest.approx(seen_at_least_once(0.7, 10), abs=0.01)


def test_occlusion_of_the_simulated_forest_is_less_alike_from_further_apart() -> None:
    # A small world and a few thousand rays: the benchmark measures it with care.
    rng = np.random.default_rng(0)
    forest = RayCaster(build_scene(SceneParameters(seed=3, side_m=40.0)).forest.mesh.triangles_enu_m)
    ground = np.column_stack((rng.uniform(-12, 12, 3000), rng.uniform(16, 40, 3000), np.full(3000, 0.05)))
    first = ground + np.column_stack((rng.uniform(-6, 6, (3000, 2)), np.full(3000, 35.0)))
    east = np.array([1.0, 0.0, 0.0])

    def free(cameras: NDArray[np.float64]) -> NDArray[np.bool_]:
        return forest.is_free(ground.astype(np.float32), (cameras - ground).astype(np.float32))

    alike = [np.corrcoef(free(first), free(first + step_m * east))[0, 1] for step_m in (0.1, 0.4, 6.0)]
    assert alike[0] > alike[1] + 0.1 > alike[2] + 0.2


def test_ten_cameras_even_out_what_one_sees_of_the_persons_in_the_simulated_forest() -> None:
    rng = np.random.default_rng(0)
    scene = build_scene(SceneParameters(seed=3, side_m=40.0, persons=12))
    renderer = Renderer(scene)
    camera = CameraModel.from_fov(160, 160, math.radians(50.0))
    shares = np.array(
        [
            [
                person_visibility(renderer, nadir_pose([*place, 35.0]), camera, person.name)
                for place in person.position_enu_m[:2] + rng.uniform(-6.0, 6.0, (10, 2))
            ]
            for person in scene.persons
        ],
        dtype=np.float64,
    )
    # Were the cameras independent, the mean of ten would vary by a tenth of one; were they alike, as much as one.
    reduction = shares.mean(axis=1).var() / shares.var()
    assert 0.05 < reduction < 0.6


def test_the_plan_proposes_what_the_functions_say() -> None:
    plan = plan_aperture(**FOREST)
    assert plan.drones == samples_for(0.85, 0.95) == 10
    assert plan.layers_m == tuple(35.0 + 2.0 * layer for layer in range(10))
    assert plan.spacing_m == pytest.approx(smallest_spacing_m(53.0, 12.0, 1.0))
    assert plan.samples_in_view == 10
    assert plan.saturation >= 0.95
    assert plan.single_visibility < plan.visibility < plan.seen_at_least_once


def test_cameras_beyond_the_footprint_do_not_count() -> None:
    plan = plan_aperture(**{**FOREST, "fov_rad": math.radians(20.0)}, drones=30)
    assert plan.drones == 30
    assert packed_aperture_m(30, plan.spacing_m) > footprint_m(35.0, math.radians(20.0))
    assert 1 <= plan.samples_in_view < 30
    assert f"{plan.samples_in_view} of 30" in plan.reasons[2]


@pytest.mark.parametrize(
    ("field", "value", "says"),
    [
        ("altitude_m", 18.0, "altitude_m must be above the tree tops"),
        ("altitude_m", math.nan, "altitude_m"),
        ("crown_base_m", 18.0, "crown_base_m"),
        ("occluder_size_m", 0.0, "occluder_size_m"),
        ("occlusion", 1.1, "occlusion"),
        ("saturation", 1.0, "saturation"),
        ("layer_spacing_m", -1.0, "layer_spacing_m"),
        ("drones", 0, "drones"),
        ("drones", 100_000_000, "A mission has 1 to 250 drones"),
        ("saturation", 0.9999999, "a lower saturation"),
        ("altitude_m", math.inf, "altitude_m must be finite"),
        ("layer_spacing_m", math.inf, "layer_spacing_m must be a finite number"),
        ("fov_rad", math.pi, "field of view"),
    ],
)
def test_bad_numbers_are_named(field: str, value: float, says: str) -> None:
    with pytest.raises(ConfigurationError, match=says):
        plan_aperture(**{**FOREST, field: value})


def test_the_command_prints_the_plan_with_its_reasons(capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_status(["--log-level", "error", "plan-aperture", "--layer-spacing", "0"]) == 0
    text = capsys.readouterr().out
    assert "spacing c4: 2.9 m" in text
    assert "drones: 10" in text
    assert "share occluders" in text


def test_the_command_prints_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_status(["--log-level", "error", "plan-aperture", "--json", "--drones", "6"]) == 0
    plan = json.loads(capsys.readouterr().out)
    assert plan["drones"] == len(plan["layers_m"]) == 6
    assert len(plan["reasons"]) == 3
    low_m, high_m, *_ = plan["layers_m"]
    assert high_m - low_m == FlightSettings().layer_spacing_m, "as missions fly"
