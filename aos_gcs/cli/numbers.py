"""Several numbers in one option."""

from __future__ import annotations

import math


def parse_numbers(text: str) -> list[float]:
    """Return numbers parted by commas; none at all unless all of them are finite."""
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        return []
    return numbers if all(math.isfinite(number) for number in numbers) else []
