"""The driver's exchanges with a simulated vehicle over a link that loses, doubles and delays messages."""

from __future__ import annotations

import numpy as np
import pytest

from aos_drivers.vehicle.autopilots.base import Target
from aos_drivers.vehicle.exchange import Exchange
from aos_drivers.vehicle.fence.items import items_of, polygons_of
from aos_drivers.vehicle.fence.transfer import FenceDownload, FenceUpload
from aos_drivers.vehicle.parameters.encoding import Parameter, ParameterEncoding
from aos_drivers.vehicle.parameters.transfer import ParameterRead, ParameterWrite
from aos_gcs.ports import Geofence

TARGET, OURS = Target(7, 1), 254
FENCE = Geofence(
    tuple((48.3 + 0.001 * np.sin(angle), 14.3 + 0.001 * np.cos(angle)) for angle in np.linspace(0.0, 5.0, 5)),
    (((48.3, 14.3), (48.3001, 14.3), (48.3, 14.3001)),),
)
ENCODINGS = {"arducopter": ParameterEncoding.CAST, "px4": ParameterEncoding.BYTEWISE}
FENCE_PARAMETERS = {"arducopter": {"FENCE_TYPE": 5.0, "FENCE_ALT_MAX": 42.5}, "px4": {"GF_ACTION": 3.0}}


def converse(bench, exchange: Exchange, rng: np.random.Generator, lost: float, limit_s: float = 300.0) -> float:
    """Have both talk, every tenth of a second, until all is said; return how long that took."""
    under_way: list[tuple[float, bool, object]] = []
    start_s = bench.now.s

    def send(message: object, *, is_ours: bool) -> None:
        for _ in range(1 + (rng.random() < 0.1)):
            if rng.random() >= lost:
                under_way.append((bench.now.s + rng.choice([0.0, 0.1, 0.4]), is_ours, message))

    while not exchange.is_done:
        assert bench.now.s - start_s < limit_s, "it never came to an end"
        for message in exchange.poll(bench.now.s):
            send(message, is_ours=True)
        arrived = [entry for entry in under_way if entry[0] <= bench.now.s]
        under_way = [entry for entry in under_way if entry[0] > bench.now.s]
        for _, is_ours, message in arrived:
            if is_ours:
                for reply in bench.send(message, OURS):
                    send(reply, is_ours=False)
            else:
                exchange.on_message(message)
        before = len(bench.sent)
        bench.advance(0.1)
        for message in bench.sent[before:]:
            if message.get_type().startswith(("MISSION", "PARAM")):
                send(message, is_ours=False)
    return bench.now.s - start_s


@pytest.mark.parametrize(
    ("flavour", "lost"),
    [("arducopter", 0.0), ("arducopter", 0.3), ("px4", 0.0), pytest.param("px4", 0.3, marks=pytest.mark.slow)],
)
def test_a_fence_arrives_whole_and_is_told_whole(make_bench, flavour: str, lost: float) -> None:
    bench, rng = make_bench(flavour), np.random.default_rng(1)
    took_s = converse(bench, FenceUpload(TARGET, items_of(FENCE, TARGET), OURS), rng, lost)
    download = FenceDownload(TARGET, OURS)
    converse(bench, download, rng, lost)
    inclusions, exclusions, others = polygons_of(download.items)
    assert Geofence(inclusions[0], tuple(exclusions)).is_same_as(FENCE)
    assert (len(inclusions), others) == (1, 0)
    if not lost:
        assert took_s < 10.0, "simulated seconds"


@pytest.mark.parametrize("flavour", ["arducopter", "px4"])
def test_parameters_arrive_and_are_told_in_the_end(make_bench, flavour: str) -> None:
    bench, rng = make_bench(flavour), np.random.default_rng(1)
    encoding, wanted = ENCODINGS[flavour], FENCE_PARAMETERS[flavour]
    read = ParameterRead(TARGET, encoding, [(name,) for name in wanted])
    converse(bench, read, rng, 0.5)
    changed = {name: Parameter(value, read.found[name].kind) for name, value in wanted.items()}
    converse(bench, ParameterWrite(TARGET, encoding, changed), rng, 0.5)
    assert {name: bench.autopilot.parameters[name] for name in wanted} == wanted
    again = ParameterRead(TARGET, encoding, [(name,) for name in wanted])
    converse(bench, again, rng, 0.5)
    assert {name: parameter.value for name, parameter in again.found.items()} == wanted
