"""The flights of autopilots in software: their parameter files say what docs/sitl.md says."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from aos_gcs.config.file import read_config
from tests.sitl.flights.autopilots import ArduCopter, Offsets, Px4
from tests.sitl.flights.scenarios import RELIEF, SEARCH
from tests.sitl.flights.station import Setting, mission_file

ROOT = Path(__file__).resolve().parents[2]
HOME = (48.3, 14.3, 260.0)


@pytest.fixture(scope="module")
def guide():
    return (ROOT / "docs/sitl.md").read_text(encoding="utf-8")


def parameters(name):
    lines = (ROOT / "tests/sitl/flights" / name).read_text(encoding="utf-8").splitlines()
    return dict(line.split() for line in lines if line and not line.startswith("#"))


def test_guide_states_the_copters_values(guide):
    values = parameters("copter.parm")
    rows = re.findall(r"^\| ((?:`[A-Z0-9_]+`,? ?)+) \| ([\d, ]+) \|", guide, re.MULTILINE)
    stated = {
        name: value
        for names, numbers in rows
        for name, value in zip(re.findall(r"`(\w+)`", names), numbers.split(", "), strict=True)
    }
    assert len(stated) == 11
    assert stated.items() <= values.items()


def test_guide_starts_px4_with_the_files_values(guide):
    assert dict(re.findall(r"PX4_PARAM_(\w+)=(\w+)", guide)) == parameters("px4.parm")


@pytest.mark.parametrize("kind", [ArduCopter(Path("arducopter")), Px4(Path("px4"))])
def test_everything_stays_on_the_loopback_interface(kind):
    links = [kind.station_link, *kind.camera_links(3)]
    assert all("://127.0.0.1:" in link for link in links)
    assert len(set(links)) == 4


@pytest.mark.parametrize("kind", [ArduCopter(Path("arducopter")), Px4(Path("px4"))])
@pytest.mark.parametrize("setting", [Setting(), SEARCH, RELIEF])
def test_the_configuration_of_every_flight_is_valid(kind, setting, tmp_path):
    file = tmp_path / "mission.toml"
    file.write_text(mission_file(kind, setting), encoding="utf-8")
    config = read_config(file)
    assert config.link.urls == [kind.station_link]
    assert config.flight["layer_spacing_m"] == kind.layer_spacing_m


def test_offsets_are_passed_to_the_simulators():
    offsets = Offsets(receiver_m=6.0, barometer_drift_mps=0.05)
    copter = ArduCopter(Path("arducopter")).command(1, 2, HOME, offsets)
    assert copter.files["errors.parm"] == "SIM_GPS1_ALT_OFS 6.0\nSIM_BARO_DRIFT 0.05\n"
    px4 = Px4(Path("px4")).command(1, 2, HOME, offsets)
    assert px4.environment["PX4_HOME_ALT"] == "266.0"
    assert px4.environment["PX4_PARAM_NAV_DLL_ACT"] == "2"
