import json
import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from aos_gcs.mission.model.actions import ActionRecord
from aos_gcs.mission.model.events import NoticeRecord, PicturesRecord
from aos_gcs.mission.model.findings import TargetEstimate
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.steps import StepRecord
from aos_gcs.ports import VehicleState
from aos_gcs.store.codec import decode, encode

MODELS = (MissionSnapshot, StepRecord, NoticeRecord, PicturesRecord, ActionRecord, TargetEstimate, VehicleState)


def through_json(value: object) -> object:
    return json.loads(json.dumps(encode(value), allow_nan=False))


@pytest.mark.parametrize("model", MODELS)
@settings(max_examples=12, deadline=None)
@given(data=st.data())
def test_every_record_of_the_model_survives_exactly(model: type, data: st.DataObject) -> None:
    record = data.draw(st.from_type(model))
    # repr shows types, every bit of the numbers, and not-a-number as equal to itself
    assert repr(decode(model, through_json(record))) == repr(record)


def test_a_step_reads_like_the_model() -> None:
    plain = encode(TargetEstimate(position_enu_m=(1.5, -2.0, 0.1), sigma_m=None, sightings=2))
    assert plain == {
        "position_enu_m": [1.5, -2.0, 0.1],
        "sigma_m": None,
        "sightings": 2,
        "track_id": 0,
        "confirmed": True,
        "ellipse": None,
        "velocity_enu_mps": None,
        "seen_at_s": None,
        "person_confidence": None,
        "significance": None,
        "kind": "undecided",
        "reasons": [],
    }


@pytest.mark.parametrize(("number", "plain"), [(math.inf, "inf"), (-math.inf, "-inf"), (math.nan, "nan")])
def test_numbers_that_json_lacks_are_words(number: float, plain: str) -> None:
    assert encode(number) == plain
    assert encode(np.float64(number)) == plain
    assert decode(float, plain) == pytest.approx(number, nan_ok=True)


@dataclass(frozen=True, slots=True, eq=False)
class State:
    positions_enu_m: NDArray[np.float64]
    counts: NDArray[np.int64]
    best: float | None = None


def test_arrays_keep_shape_type_and_every_bit() -> None:
    positions = np.random.default_rng(1).normal(size=(4, 2))
    positions[1, 1] = np.nan
    state = decode(State, through_json(State(positions, np.arange(3))))
    np.testing.assert_array_equal(state.positions_enu_m, positions)
    assert state.positions_enu_m.dtype == np.float64
    np.testing.assert_array_equal(state.counts, [0, 1, 2])
    assert state.best is None


def test_a_restored_generator_draws_the_same_numbers() -> None:
    rng = np.random.default_rng(7)
    rng.normal(size=5)
    restored = np.random.default_rng()
    restored.bit_generator.state = through_json(rng.bit_generator.state)
    np.testing.assert_array_equal(restored.normal(size=5), rng.normal(size=5))


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        ({"position_enu_m": [1.0, 2.0, 3.0], "sigma_m": None}, "missing sightings"),
        ({"position_enu_m": [1.0, 2.0], "sigma_m": None, "sightings": 1}, "TargetEstimate.position_enu_m"),
        ({"position_enu_m": [1.0, 2.0, 3.0], "sigma_m": "x", "sightings": 1}, "TargetEstimate.sigma_m"),
        ({"position_enu_m": [1.0, 2.0, 3.0], "sigma_m": None, "sightings": True}, "TargetEstimate.sightings"),
        ({"position_enu_m": [1.0, 2.0, 3.0], "sigma_m": None, "sightings": 1, "colour": 1}, "unknown colour"),
        ([], "expected"),
    ],
)
def test_data_that_do_not_fit_name_the_field(data: object, reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        decode(TargetEstimate, data)


def test_an_unknown_word_of_an_enumeration_is_refused() -> None:
    with pytest.raises(ValueError, match="dancing"):
        decode(Phase, "dancing")


def test_what_json_cannot_hold_is_refused_by_name() -> None:
    with pytest.raises(TypeError, match="cannot record a bytes"):
        encode({"png": b""})


def test_keys_may_be_words_of_an_enumeration() -> None:
    class Colour(StrEnum):
        RED = "red"

    assert encode({Colour.RED: 1, 2: 3}) == {"red": 1, "2": 3}


@pytest.mark.parametrize(
    ("dtype", "shape"),
    [("-1", [1]), ("O", [1]), ("<U9", [1]), (None, [1]), ("<f8", [-1]), ("<f8", "1"), ("<f8", [10**30]), ("<f8", None)],
)
def test_an_array_of_no_known_kind_is_refused(dtype: object, shape: object) -> None:
    with pytest.raises(ValueError, match=r".+"):
        decode(np.ndarray, {"dtype": dtype, "shape": shape, "values": [1.0]})
