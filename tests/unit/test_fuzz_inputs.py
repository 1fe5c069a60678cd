"""A share of the packets and images of ``python -m tests.fuzz_inputs``."""

from __future__ import annotations

import pytest

from tests.fuzz import SEED
from tests.fuzz_inputs import IMAGES_PER_ROUND, PACKETS_PER_ROUND, feed_images, feed_packets, run


@pytest.mark.parametrize("count", [3_000, pytest.param(1_000_000, marks=[pytest.mark.slow, pytest.mark.timeout(7200)])])
def test_no_packet_breaks_the_session(count: int) -> None:
    valid = run(feed_packets, count, PACKETS_PER_ROUND, SEED)
    assert 0.3 * count < valid < count


@pytest.mark.parametrize("count", [500, pytest.param(50_000, marks=[pytest.mark.slow, pytest.mark.timeout(7200)])])
def test_no_image_breaks_its_decoder(count: int) -> None:
    read = run(feed_images, count, IMAGES_PER_ROUND, SEED)
    assert 0.02 * count < read < 0.9 * count


def test_what_is_raised_names_the_seed_of_its_round() -> None:
    def feed(_count: int, seed: int) -> int:
        if seed == 7:
            raise ValueError("broken")
        return 1

    with pytest.raises(ValueError, match="broken") as caught:
        run(feed, 50, 10, 5)
    assert caught.value.__notes__ == ["repeat it with --seed 7 --count 10"]
