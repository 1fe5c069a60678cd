"""Settings of a mission from a configuration file."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import pytest

from aos_gcs.airspace.limits import SafetyOverrides
from aos_gcs.config.file import parse_config, read_config
from aos_gcs.config.model import ServiceConfig
from aos_gcs.config.settings import mission_settings
from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.imaging.model import AnomalySource, Detector, LeaderCriterion
from aos_gcs.planning.settings import PreflightSettings
from tests.fakes.relief import ORIGIN as RELIEF_ORIGIN
from tests.fakes.relief import hill, write_relief

ORIGIN = GeodeticPosition(48.3, 14.3, 260.0)
SQUARE = [[-10.0, 0.0], [10.0, 0.0], [10.0, 40.0], [-10.0, 40.0]]


def tables(**sections: Any) -> dict[str, Any]:
    mission = {"vehicles": 3, "area_enu_m": SQUARE} | sections.pop("mission", {})
    mission = {name: value for name, value in mission.items() if value is not None}
    return {"link": {"urls": ["udpin://0.0.0.0:14550"]}, "mission": mission, **sections}


def configuration(**sections: Any) -> ServiceConfig:
    return parse_config(tables(**sections))


def test_uncertainties_are_given_in_degrees_and_kept_in_radians() -> None:
    config = configuration(
        uncertainty={"yaw_deg": 5.0, "position_horizontal_m": 0.02}, tracking={"motion": {"walking_speed_mps": 1.0}}
    )
    settings = mission_settings(config)
    assert settings.uncertainty.yaw_rad == pytest.approx(math.radians(5.0))
    assert settings.uncertainty.attitude_rad == pytest.approx(math.radians(1.0))
    assert settings.uncertainty.position_horizontal_m == 0.02
    assert settings.tracking.motion.walking_speed_mps == 1.0


def test_a_short_file_takes_the_defaults_of_the_core(tmp_path: Path) -> None:
    file = tmp_path / "mission.toml"
    file.write_text(
        '[link]\nurls = ["udpin://0.0.0.0:14550"]\n'
        "[mission]\nvehicles = 3\narea_enu_m = [[-10, 0], [10, 0], [10, 40], [-10, 40]]\n",
        encoding="utf-8",
    )
    assert read_config(file) == configuration()
    settings = mission_settings(read_config(file))
    assert settings.vehicles == 3
    assert settings.origin is None
    assert settings.safety == SafetyOverrides()
    assert settings.strategy == "aos-apso"
    assert not settings.auto_start


def test_corners_in_degrees_become_metres_about_the_origin() -> None:
    frame = LocalFrame(ORIGIN)
    corners_deg = [
        (position.latitude_deg, position.longitude_deg)
        for position in (frame.to_geodetic([east_m, north_m, 0.0]) for east_m, north_m in SQUARE)
    ]
    origin_deg = (ORIGIN.latitude_deg, ORIGIN.longitude_deg, ORIGIN.altitude_amsl_m)
    mission = {"area_enu_m": None, "area_deg": corners_deg, "origin_deg": origin_deg}
    safety = {"fence_deg": corners_deg, "no_go_deg": [corners_deg[:3]]}
    settings = mission_settings(configuration(mission=mission, safety=safety))
    assert settings.origin == ORIGIN
    for corner, expected in zip(settings.area_enu_m, SQUARE, strict=True):
        assert corner == pytest.approx(expected, abs=1e-3)
    assert settings.safety == SafetyOverrides(fence_enu_m=settings.area_enu_m, no_go_enu_m=(settings.area_enu_m[:3],))


@pytest.mark.parametrize(("heading_deg", "direction_enu"), [(0.0, (0.0, 1.0)), (90.0, (1.0, 0.0)), (225.0, None)])
def test_headings_turn_clockwise_from_north(heading_deg: float, direction_enu: tuple[float, float] | None) -> None:
    settings = mission_settings(configuration(mission={"scan_heading_deg": heading_deg}))
    expected = direction_enu or (-math.sqrt(0.5), -math.sqrt(0.5))
    assert settings.scan_direction_enu == pytest.approx(expected, abs=1e-12)


def test_sections_reach_the_settings_of_the_core() -> None:
    settings = mission_settings(
        configuration(
            flight={"lowest_layer_m": 40, "layer_spacing_m": 3},
            detection={"found_steps": 4},
            imaging={
                "leader_criterion": "integral",
                "plane_height_m": 1.5,
                "detector": "local_rx",
                "anomaly_source": "integral",
            },
            deadlines={"capture_s": 7},
            safety={"separation_m": 3, "ceiling_m": 60},
        )
    )
    assert settings.flight.lowest_layer_m == 40.0
    assert settings.detection.found_steps == 4
    assert settings.imaging.leader_criterion is LeaderCriterion.INTEGRAL
    assert settings.imaging.detector is Detector.LOCAL_RX
    assert settings.imaging.detector_of(("red", "green", "blue", "thermal")) is Detector.LOCAL_RX
    assert settings.imaging.anomaly_source is AnomalySource.INTEGRAL
    assert settings.deadlines.capture_s == 7.0
    assert settings.safety == SafetyOverrides(separation_m=3.0, ceiling_m=60.0)


@pytest.mark.parametrize(
    ("sections", "text"),
    [
        ({"link": {"urls": []}}, "link.urls"),
        ({"clock_speed": 0}, "clock_speed"),
        ({"mission": {"seed": -1}}, "mission.seed"),
        ({"mission": {"origin_deg": [48.0, 14.0]}}, "mission.origin_deg"),
        ({"api": {"port": 70000}}, "api.port"),
        ({"api": {"port": True}}, "api.port must be a number, but is true"),
        ({"api": {"port": "10"}}, 'api.port must be a number, but is the text "10"'),
        ({"mission": {"vehicles": True}}, "mission.vehicles must be a number, but is true"),
        ({"mission": {"auto_start": "yes"}}, "mission.auto_start must be true or false, without quotes, but is the te"),
        ({"mission": {"auto_start": 1}}, "mission.auto_start must be true or false, without quotes, but is 1"),
        ({"mision": {}}, "mision is unknown; known are: link, mission"),
        ({"link": {"urls": ["udpin://:1"], "system_id": 300}}, "link.system_id must be at most 255"),
        ({"api": {"port": 80.5}}, "api.port must be a whole number"),
        ({"swarm": {"strategy": 5}}, "swarm.strategy must be text"),
        ({"api": {"plans_folder": __file__}}, "api.plans_folder: .* is a file; name a folder"),
        ({"record": {"folder": __file__}}, "record.folder: .* is a file; name a folder"),
        ({"api": {"allowed_hosts": ["http://station.local/"]}}, r"api.allowed_hosts\[0\]: give a name without scheme"),
        ({"mission": {"vehicle_ids": [1, True]}}, r"mission.vehicle_ids\[1\] must be a number, but is true"),
        ({"mission": {"area_enu_m": [[0.0, 0.0], [1.0, "1"], [0.0, 1.0]]}}, r"mission.area_enu_m\[1\]\[1\] must be"),
        ({"clock_speed": "2"}, "clock_speed must be a number"),
        ({"api": {"host": ""}}, 'api.host: .*give an address such as "127.0.0.1"'),
        ({"api": {"host": " "}}, "api.host: .*to listen in all networks"),
        ({"mission": {"camera_fov_deg": float("nan")}}, "mission.camera_fov_deg"),
    ],
)
def test_wrong_types_and_ranges_name_the_field(sections: dict[str, Any], text: str) -> None:
    with pytest.raises(ConfigurationError, match=text):
        configuration(**sections)


def test_named_vehicles_are_counted() -> None:
    settings = mission_settings(configuration(mission={"vehicles": None, "vehicle_ids": [4, 2, 7], "auto_start": True}))
    assert (settings.vehicles, settings.vehicle_ids, settings.any_vehicles) == (3, (2, 4, 7), False)


@pytest.mark.parametrize(
    ("sections", "text"),
    [
        ({"mission": {"auto_start": True}}, "has to name its vehicles"),
        ({"safety": {"fence_enu_m": [[30, 0], [90, 0], [90, 60]]}}, "The search area leaves the geofence"),
        ({"safety": {"no_go_enu_m": [[[-20, -10], [20, -10], [20, 50], [-20, 50]]]}}, "cover the whole search area"),
        ({"api": {"enabled": False}}, "has to name its vehicles"),
        ({"mission": {"vehicles": None}}, "give the vehicles that fly"),
        ({"mission": {"vehicle_ids": [1, 2]}}, "names 2 vehicles, but vehicles is 3"),
        ({"mission": {"vehicle_ids": [1, 2, 2]}}, "names a vehicle twice"),
        (
            {"link": {"urls": ["udpin://:14550"], "system_id": 2}, "mission": {"vehicle_ids": [1, 2, 3]}},
            "link.system_id 2 is that of a vehicle in mission.vehicle_ids",
        ),
        ({"mission": {"vehicle_ids": [1, 2, 3], "any_vehicles": True}}, "either vehicle_ids or any_vehicles"),
        ({"mission": {"area_enu_m": None, "auto_start": True}}, "only a mission that waits for an operator"),
        ({"mission": {"area_enu_m": None}, "api": {"enabled": False}}, "only a mission that waits for an operator"),
        ({"mission": {"area_deg": [[48, 14], [49, 14], [48, 15]]}}, "either as area_deg or as area_enu_m"),
        ({"mission": {"area_enu_m": [[0, 0], [1, 1], [2, 2]]}}, "mission.area_enu_m must have three or more points"),
        ({"search": {"split": True, "mode": "stops"}}, r"search\.split needs search\.mode = \"continuous\""),
        ({"search": {"split": True}}, "needs 8 vehicles, 5 that look closely and 3 that scan on, but there are 3"),
        ({"search": {"forget_min": 0}}, "search: forget_min must be a finite number above 0, or be left out for never"),
        ({"search": {"forget_min": float("nan")}}, "search: forget_min must be a finite number above 0"),
        ({"search": {"forget_min": "never"}}, r"search\.forget_min"),
        ({"search": {"look_vehicles": 1}}, "search: look_vehicles must lie within 2 and 100"),
        ({"detection": {"found_steps": "many"}}, r"detection\.found_steps"),
        ({"imaging": {"plane_height_m": -100000}}, "imaging.plane_height_m must be at least -200, but is -100000"),
        ({"flight": {"search_speed_mps": 1e-9}}, "flight: search_speed_mps must be at least 0.1, but is 1e-09"),
        ({"deadlines": {"move_s": 0}}, "deadlines: move_s must be a finite number above 0"),
        ({"imaging": {"rx_quantile": 1.0}}, "imaging: rx_quantile"),
        ({"uncertainty": {"yaw_rad": 0.1}}, "give yaw_deg"),
        ({"uncertainty": {"attitude_deg": "level"}}, r"uncertainty\.attitude_deg"),
        ({"uncertainty": {"clock_s": -1.0}}, "uncertainty: clock_s"),
        ({"uncertainty": {"gnss_m": 1.0}}, r"uncertainty\.gnss_m is unknown"),
        ({"tracking": {"confirm_hits": 9}}, "tracking: confirm_hits"),
        ({"tracking": {"motion": {"still_s": 0.0}}}, r"tracking\.motion: still_s"),
        ({"tracking": {"motion": {"speed": 0.0}}}, r"tracking\.motion\.speed is unknown"),
        ({"tracking": {"motion": 3}}, r"tracking\.motion"),
        ({"imaging": {"detector": "cnn"}}, r"imaging\.detector"),
        ({"autofocus": {"enabled": True, "reach_m": 40.0}}, r"autofocus\.reach_m \(40\) above .* must be below"),
        ({"autofocus": {"interval_steps": 0}}, "autofocus: interval_steps must be a finite number above 0"),
        ({"registration": {"min_confidence": 2.0}}, "registration: min_confidence must be at most 1"),
        ({"registration": {"certain": True}}, r"registration\.certain is unknown"),
        (
            {"forest": {"canopy_height_m": 40.0, "crown_base_m": 6.0}},
            r"forest\.canopy_height_m \(40 m .* must lie below flight\.lowest_layer_m \(35\)",
        ),
        ({"flight": {"lowest_layer_m": 4.9}}, "flight: lowest_layer_m must be at least 5, but is 4.9"),
        ({"autofocus": {"enabled": "1"}}, "autofocus.enabled must be true or false, without quotes, but is the text"),
        ({"search": {"split": 1}}, "search.split must be true or false, without quotes, but is 1"),
        ({"search": {"mode": "fast"}}, "search.mode must be 'continuous' or 'stops'"),
        ({"flight": {"lowest_layer_m": True}}, r"flight\.lowest_layer_m must be a number, but is true"),
        ({"flight": {"lowest_layer_m": "40"}}, r'flight\.lowest_layer_m must be a number, but is the text "40"'),
        ({"search": {"forget_min": False}}, r"search\.forget_min must be a number, but is false"),
        ({"uncertainty": {"yaw_deg": "3"}}, r"uncertainty\.yaw_deg must be a number"),
        (
            {"safety": {"no_go_enu_m": [[[0, 0], [1, "0"], [1, 1]]]}},
            r"safety\.no_go_enu_m\[0\]\[1\]\[1\] must be a num",
        ),
        ({"safety": {"max_link_age_s": 61}}, r"safety\.max_link_age_s must be at most 60, but is 61"),
        ({"safety": {"max_position_age_s": 1e9}}, r"safety\.max_position_age_s must be at most 60, but is 1e\+09"),
        ({"safety": {"max_link_age_s": 601}, "clock_speed": 10}, r"safety\.max_link_age_s must be at most 600"),
        ({"deadlines": {"lost_s": 1e9}}, r"deadlines\.lost_s must be at most 120, but is 1e\+09: it would never act"),
        ({"detection": {"threshold_m2": 1e9}}, r"detection\.threshold_m2 must be at most 10, but is 1e\+09"),
        ({"forest": {}}, r"forest\.canopy_height_m"),
        ({"safety": {"min_battery_fraction": 20}}, "safety: min_battery_fraction must be 0 or more and below 1"),
        ({"safety": {"fence_enu_m": SQUARE, "fence_deg": [[1, 2]]}}, "either as fence_deg or as fence_enu_m"),
        ({"safety": {"no_go_enu_m": [SQUARE], "no_go_deg": []}}, "either as no_go_deg or as no_go_enu_m"),
        ({"safety": {"no_go_deg": [[[1, 2], [3, 4]]]}}, "no_go_deg needs mission.origin_deg"),
        ({"safety": {"fence_enu_m": [[0, 0], [5, 5], [5, 0], [0, 5]]}}, "fence_enu_m must not cross"),
    ],
)
def test_contradictions_are_found_before_anything_is_opened(sections: dict[str, Any], text: str) -> None:
    with pytest.raises(ConfigurationError, match=text):
        mission_settings(configuration(**sections))


def test_several_problems_are_counted() -> None:
    with pytest.raises(ConfigurationError, match=r"\(and 1 more\)"):
        parse_config({"link": {"urls": ["udpin://0.0.0.0:1"]}, "mission": {"vehicles": 0, "seed": -1}})


def test_learning_and_advice_are_off_unless_they_are_asked_for() -> None:
    settings = mission_settings(configuration())
    assert not settings.autofocus.is_due(3)
    assert not settings.registration.is_due(1)
    assert settings.forest is None


def test_learning_and_advice_are_configured() -> None:
    settings = mission_settings(
        configuration(
            imaging={"plane_height_m": 2.0},
            autofocus={"enabled": True, "reach_m": 5.0, "interval_steps": 2},
            registration={"enabled": True, "min_confidence": 0.8},
            forest={"canopy_height_m": 18.0, "crown_base_m": 6.0},
        )
    )
    assert settings.focus_range_m == (-3.0, 7.0)
    assert [settings.autofocus.is_due(step) for step in (1, 2, 3, 4)] == [False, True, False, True]
    assert settings.registration.min_confidence == 0.8
    assert settings.forest is not None


def test_standing_overrides_name_a_check_and_a_reason() -> None:
    table = {"overrides": ["link-loss failsafe: pilots: stand by"], "upload_fence": True, "set_return_height": True}
    preflight = mission_settings(configuration(preflight=table)).preflight
    overrides = {"link-loss failsafe": "pilots: stand by"}
    assert preflight == PreflightSettings(upload_fence=True, set_return_height=True, overrides=overrides)
    assert not mission_settings(configuration()).preflight.set_return_height, "settings of vehicles are left alone"


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("link: why not", "'link' cannot be overridden; only these can: altitude accuracy, arming checks, battery"),
        ("camera", "'camera' needs a reason"),
        ("camera: ", "'camera' needs a reason"),
    ],
)
def test_standing_overrides_that_are_none_are_refused(text: str, problem: str) -> None:
    with pytest.raises(ConfigurationError, match=problem):
        mission_settings(configuration(preflight={"overrides": [text]}))


@pytest.mark.parametrize(
    ("terrain", "words"),
    [
        ({"kind": "terrain"}, "terrain.files"),
        ({"files": ["a.tif"]}, "terrain.kind"),
        ({"files": ["a.tif"], "kind": "ground"}, "terrain.kind"),
        ({"files": [], "kind": "terrain"}, "terrain: files must name"),
        ({"files": ["a.tif"], "kind": "terrain", "datum": "amsl"}, "terrain.datum"),
        ({"files": ["a.tif"], "kind": "terrain", "height_m": 3.0}, "terrain.height_m is unknown"),
        ({"files": ["a.tif"], "kind": "terrain", "ceiling_above_ground_m": -1.0}, "terrain: ceiling_above_ground_m"),
        ({"files": ["a.tif"], "kind": "terrain", "floor_above_ground_m": 130.0}, "terrain: floor_above_ground_m (130)"),
        ({"files": ["gone.tif"], "kind": "terrain"}, "terrain: The elevation model gone.tif does not exist"),
    ],
)
def test_an_elevation_model_that_cannot_be_used_is_refused_by_its_field(terrain: dict[str, Any], words: str) -> None:
    pytest.importorskip("rasterio")
    with pytest.raises(ConfigurationError, match=re.escape(words)):
        mission_settings(configuration(terrain=terrain))


def test_a_mission_that_meets_the_ground_is_refused(tmp_path: Path) -> None:
    pytest.importorskip("rasterio")
    file = write_relief(tmp_path / "ground.tif", hill(0.0, 30.0, 25.0, radius_m=15.0))
    origin = (RELIEF_ORIGIN.latitude_deg, RELIEF_ORIGIN.longitude_deg, RELIEF_ORIGIN.altitude_amsl_m)
    mission, terrain = {"origin_deg": list(origin)}, {"files": [str(file)], "kind": "terrain"}
    with pytest.raises(
        ConfigurationError, match=r"cannot be flown \(lowest_layer_m\): Search area: at 47\.5.* below the"
    ):
        mission_settings(configuration(mission=mission, terrain=terrain))
    settings = mission_settings(configuration(mission=mission, terrain=terrain | {"floor_above_ground_m": 9.0}))
    assert settings.terrain is not None
    assert settings.terrain.ceiling_above_ground_m == 120.0
    assert mission_settings(configuration(mission=mission)).terrain is None


def test_whole_numbers_are_numbers_and_text_stays_text() -> None:
    settings = mission_settings(configuration(flight={"lowest_layer_m": 40}, search={"pod": None}, clock_speed=2))
    assert settings.flight.lowest_layer_m == 40.0
    ages = {"max_link_age_s": 300, "max_position_age_s": 300}
    fast = configuration(safety=ages, clock_speed=100, link={"urls": ["a"], "options": {"any": "1"}})
    assert mission_settings(fast).safety == SafetyOverrides(**ages)
