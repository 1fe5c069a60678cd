"""Answers of workers: they come back as they were, and no bytes do anything but become data or be refused."""

from __future__ import annotations

import json
import os
import pickle
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from aos_gcs.errors import AosError, UnusableFramesError
from aos_gcs.imaging.model import FocalGrid
from aos_gcs.imaging.pictures import RasterPicture
from aos_gcs.mission.model.phase import Phase
from aos_gcs.workers.answers import MalformedAnswerError, pack_error, pack_result, unpack_answer
from aos_gcs.workers.arena import Arena
from tests.fuzz import SEED, damage

LIMIT = 2**20
GRID = FocalGrid(west_m=-1.0, north_m=2.0, resolution_m=0.5, rows=2, columns=3, height_m=0.0)
RASTER = "aos_gcs.imaging.pictures:RasterPicture"


@pytest.fixture
def arena() -> Iterator[Arena]:
    arena = Arena.create()
    yield arena
    arena.close()


def returned(value: object, arena: Arena) -> Any:
    is_result, result = unpack_answer(pack_result(value, arena), Arena(os.dup(arena.fd)), LIMIT)
    assert is_result
    return result


def raised(error: Exception, arena: Arena) -> Exception:
    is_result, result = unpack_answer(pack_error(error, arena), Arena(os.dup(arena.fd)), LIMIT)
    assert not is_result
    assert isinstance(result, Exception)
    return result


PLAIN = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text() | st.binary() | st.just(GRID),
    lambda inner: (
        st.lists(inner)
        | st.lists(inner).map(tuple)
        | st.dictionaries(st.integers() | st.text() | st.tuples(st.integers()), inner)
    ),
    max_leaves=20,
)


@given(PLAIN)
def test_plain_values_come_back_as_they_were(value: object) -> None:
    arena = Arena.create()
    result = returned(value, arena)
    arena.close()
    assert result == value
    assert type(result) is type(value)


@given(
    hnp.arrays(hnp.boolean_dtypes() | hnp.integer_dtypes() | hnp.floating_dtypes(sizes=(32, 64)), hnp.array_shapes())
)
def test_arrays_come_back_as_they_were(values: np.ndarray[Any, Any]) -> None:
    arena = Arena.create()
    for array in (values, values.T, values[::-1], np.asfortranarray(values)):
        result = returned({"a": array, "b": array}, arena)
        np.testing.assert_array_equal(result["a"], array)
        assert result["a"].dtype == array.dtype
        assert result["a"].flags.writeable
    scalar = returned(values.reshape(-1)[0], arena)
    assert type(scalar) is type(values.reshape(-1)[0])
    arena.close()


def test_data_enums_and_numbers_of_all_kinds_come_back(arena: Arena) -> None:
    picture = RasterPicture("integral", b"png", 0.0, float("inf"), 2.0, -0.0)
    values = [picture, Phase.SCAN, {Phase.SCAN: 1}, frozenset({1}), {2}, np.float32(0.1), float("nan"), 10**30]
    result = returned(values, arena)
    assert repr(result) == repr(values)
    assert result[0] == picture


def test_errors_come_back_with_what_they_know(arena: Arena) -> None:
    error = UnusableFramesError("none can be used", {3: "blurred"})
    error.add_note("at home")
    result = raised(error, arena)
    assert isinstance(result, UnusableFramesError)
    assert (str(result), result.reasons, result.__notes__) == ("none can be used", {3: "blurred"}, ["at home"])
    assert repr(raised(ZeroDivisionError("by zero"), arena)) == "ZeroDivisionError('by zero')"
    assert repr(raised(np.linalg.LinAlgError("singular"), arena)) == "ValueError('LinAlgError: singular')"
    assert repr(raised(AosError(object()), arena)).startswith("RuntimeError('AosError: ")


@pytest.mark.parametrize("value", [object(), np.array([object()]), print, type, np.zeros(2, "V4"), Phase])
def test_what_is_no_data_is_not_answered(value: object, arena: Arena) -> None:
    with pytest.raises(TypeError, match="cannot answer"):
        pack_result(value, arena)


@pytest.mark.parametrize(
    "head",
    [
        ["data", "os:system", {}],
        ["data", "aos_gcs.workers.process:ProcessWorker", {}],
        ["data", "aos_gcs.workers.process:subprocess", {}],
        ["data", "aos_gcs.never.loaded:Anything", {}],
        ["data", "aos_gcs.imaging.model:np", {}],
        ["data", RASTER, {}],
        ["data", RASTER, {"__class__": 1, "kind": 1, "png": 1, "west_m": 1, "south_m": 1, "east_m": 1}],
        ["data", 7, {}],
        ["enum", RASTER, "kind"],
        ["enum", "aos_gcs.mission.model.phase:Phase", "__class__"],
        ["enum", "aos_gcs.mission.model.phase:Phase", ["SCAN"]],
        ["array", "|O", [1], False, 0],
        ["array", "<f8", [2**62, 2**62], False, 0],
        ["array", "<f8", [-1], False, 0],
        ["array", "<f8", [1], False, 1],
        ["array", "<f8", [1], False, -1],
        ["array", ["<f8"], [1], False, 0],
        ["scalar", "<M8[s]", 0],
        ["bytes", True],
        ["bytes"],
        ["part", 0],
        ["__class__"],
        [["list"], 1],
        ["dict", [[1]]],
        ["dict", [[["list", []], 1]]],
        {"list": []},
        [],
    ],
)
def test_hostile_values_are_refused(head: object, arena: Arena) -> None:
    arena.first(64)
    for message in (["result", [8], head], ["error", [8], head]):
        with pytest.raises(MalformedAnswerError):
            unpack_answer(json.dumps(message).encode(), arena, LIMIT)


@pytest.mark.parametrize(
    "error",
    [
        ["KeyboardInterrupt", ["tuple", []], ["dict", []], ["list", []]],
        [RASTER, ["tuple", []], ["dict", []], ["list", []]],
        ["aos_gcs.errors:AosError", ["tuple", []], ["dict", [["__class__", 1]]], ["list", []]],
        ["ValueError", ["tuple", []], ["dict", []], ["list", [1]]],
        ["ValueError"],
    ],
)
def test_hostile_errors_are_refused(error: list[object], arena: Arena) -> None:
    with pytest.raises(MalformedAnswerError):
        unpack_answer(json.dumps(["error", [], ["tuple", error]]).encode(), arena, LIMIT)


@pytest.mark.parametrize("sizes", [[2**62], [-1], [1.5], [True], "8", [LIMIT + 1], [9000]])
def test_sizes_beyond_the_memory_are_refused(sizes: object, arena: Arena) -> None:
    arena.first(64)
    with pytest.raises(MalformedAnswerError):
        unpack_answer(json.dumps(["result", sizes, None]).encode(), arena, LIMIT)


class Bomb:
    """Sets a mark when it is unpickled."""

    went_off = False

    def __reduce__(self) -> tuple[object, tuple[object, ...]]:
        return setattr, (Bomb, "went_off", True)


def test_a_pickle_is_refused_and_does_nothing(arena: Arena) -> None:
    for message in (pickle.dumps(Bomb()), pickle.dumps((pickle.dumps(Bomb()), []))):
        with pytest.raises(MalformedAnswerError):
            unpack_answer(message, arena, LIMIT)
    assert not Bomb.went_off


def test_damaged_answers_are_data_or_refused(arena: Arena) -> None:
    value = {1: (RasterPicture("integral", b"png", 0.0, 1.0, 2.0, 3.0), Phase.SCAN, np.ones((3, 4)), np.float32(1.0))}
    for whole in (pack_result(value, arena), pack_error(UnusableFramesError("no", {1: "x"}), arena)):
        for number in range(2000):
            rng = np.random.default_rng(SEED + number)
            try:
                unpack_answer(damage(whole, rng), arena, LIMIT)
            except MalformedAnswerError:
                continue
            except Exception as error:
                raise AssertionError(f"AOS_GCS_FUZZ_SEED={SEED + number}") from error


def test_the_memory_cannot_be_made_smaller_under_its_reader(arena: Arena) -> None:
    arena.first(2**16)
    with pytest.raises(PermissionError):
        os.ftruncate(arena.fd, 0)
