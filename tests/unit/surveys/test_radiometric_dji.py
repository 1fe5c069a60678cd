"""Temperatures of DJI's radiometric JPEG files, by a library that stands in for DJI's Thermal SDK."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.surveys.radiometric.dji import ThermalSdk, find_library
from aos_gcs.surveys.radiometric.reading import read_temperatures
from aos_gcs.surveys.radiometric.settings import MeasurementConditions, TemperatureSettings
from tests.fakes.dji_sdk import COLD, CRASHING, PICTURE, RADIOMETRIC, build, celsius, photograph

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")

Sdk = Callable[..., ThermalSdk]
AS_RECORDED = MeasurementConditions()


@pytest.fixture(scope="module")
def opened(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Sdk]:
    """Return a function that compiles a library with some options and opens it, once for all tests."""
    sdks: dict[tuple[str, ...], ThermalSdk] = {}

    def open_sdk(*options: str) -> ThermalSdk:
        if options not in sdks:
            sdks[options] = ThermalSdk(build(tmp_path_factory.mktemp("sdk"), *options))
        return sdks[options]

    yield open_sdk
    for sdk in sdks.values():
        sdk.close()


def test_temperatures_are_the_librarys(opened: Sdk) -> None:
    np.testing.assert_array_equal(opened().celsius(photograph(RADIOMETRIC), AS_RECORDED), celsius())


def test_the_size_is_told_without_measuring(opened: Sdk) -> None:
    # Nothing can be measured in this one.
    assert opened().size_px(photograph(COLD), AS_RECORDED) == celsius().shape
    with pytest.raises(InputDataError, match="takes a value of distance from 1 to 25"):
        opened().size_px(photograph(RADIOMETRIC), MeasurementConditions(distance_m=40.0))


def test_threads_measure_at_the_same_time(opened: Sdk) -> None:
    marks = [RADIOMETRIC, CRASHING, RADIOMETRIC, COLD] * 3
    sdk = opened()

    def measured(mark: bytes) -> bool:
        try:
            np.testing.assert_array_equal(sdk.celsius(photograph(mark), AS_RECORDED), celsius())
        except InputDataError:
            return False
        return True

    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(measured, marks)) == [mark == RADIOMETRIC for mark in marks]


def test_what_the_camera_was_set_to_can_be_replaced(opened: Sdk) -> None:
    measured = opened().celsius(photograph(RADIOMETRIC), MeasurementConditions(0.1, 20.0, 0.5, -10.0, 7.0))
    expected = celsius(emissivity=0.1, distance=20.0, humidity=50.0, reflected=-10.0, air=7.0)
    np.testing.assert_array_equal(measured, expected)


REFUSED = {
    "distance": (MeasurementConditions(distance_m=40.0), "takes a value of distance from 1 to 25 for it, not 40"),
    "humidity": (MeasurementConditions(humidity=0.1), "takes a value of humidity from 0.2 to 1 for it, not 0.1"),
    "by the library": (
        MeasurementConditions(distance_m=13.0),
        r"refuses it, or the conditions of --degrees \(error -3\)",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_conditions_that_the_library_does_not_take_are_named(opened: Sdk, case: str) -> None:
    conditions, words = REFUSED[case]
    with pytest.raises(InputDataError, match=words):
        opened().celsius(photograph(RADIOMETRIC), conditions)


def test_an_old_library_knows_no_air(opened: Sdk) -> None:
    sdk = opened("-DCONDITIONS=4")
    np.testing.assert_array_equal(
        sdk.celsius(photograph(RADIOMETRIC), MeasurementConditions(emissivity=0.5))[0, :4], [5.0, 70.0, 0.5, 23.0]
    )
    with pytest.raises(InputDataError, match="takes no air for it; leave air out of --degrees"):
        sdk.celsius(photograph(RADIOMETRIC), MeasurementConditions(air_c=7.0))


@pytest.mark.parametrize(
    ("mark", "words"),
    [
        (PICTURE, "no radiometric data of DJI, or damaged ones"),
        (COLD, "gives no temperatures for some of its pixels"),
        (CRASHING, r"DJI's Thermal SDK has ended \(SIGABRT\): the file is damaged"),
    ],
)
def test_a_file_without_temperatures_costs_no_other_one(opened: Sdk, mark: bytes, words: str) -> None:
    with pytest.raises(InputDataError, match=words):
        opened().celsius(photograph(mark), AS_RECORDED)
    np.testing.assert_array_equal(opened().celsius(photograph(RADIOMETRIC), AS_RECORDED), celsius())


@pytest.mark.parametrize(("code", "words"), [(-14, "not activated"), (-16, "libraries that it needs are missing")])
def test_a_library_that_cannot_work_is_no_fault_of_the_file(opened: Sdk, code: int, words: str) -> None:
    with pytest.raises(ConfigurationError, match=words):
        opened(f"-DOPENING={code}").celsius(photograph(RADIOMETRIC), AS_RECORDED)


def test_no_library_is_no_fault_of_the_file(tmp_path: Path) -> None:
    (tmp_path / "libdirp.so").write_text("of another system")
    sdk = ThermalSdk(tmp_path / "libdirp.so")
    with pytest.raises(ConfigurationError, match="cannot be loaded"):
        sdk.celsius(photograph(RADIOMETRIC), AS_RECORDED)
    sdk.close()


@pytest.mark.parametrize("place", ["", "linux/release_x64", "tsdk-core/lib/linux/release_x64"])
def test_the_library_is_found_in_the_sdk(tmp_path: Path, place: str) -> None:
    with pytest.raises(ConfigurationError, match="give the folder of DJI's Thermal SDK"):
        find_library(tmp_path)
    library = tmp_path / place / "libdirp.so"
    library.parent.mkdir(parents=True, exist_ok=True)
    library.touch()
    assert find_library(tmp_path) == library


def test_a_photograph_of_dji_needs_its_sdk() -> None:
    with pytest.raises(InputDataError, match=r"give its folder \(--dji-sdk\)"):
        read_temperatures(photograph(RADIOMETRIC), TemperatureSettings())


def test_a_photograph_of_another_make_is_named() -> None:
    with pytest.raises(InputDataError, match="no radiometric data of FLIR or DJI"):
        read_temperatures(b"\xff\xd8\xff\xd9", TemperatureSettings())
