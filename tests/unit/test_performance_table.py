"""The table of speed is that of its figures, and says which goals are missed."""

from __future__ import annotations

import json

import pytest

from tests.benchmarks.performance import DATA, NO_RELEASE, NONE_YET, TABLE, is_missed, line, table


@pytest.mark.parametrize(
    ("goal", "value", "ratio", "missed"),
    [
        ("≤ 90 ms", 90.0, None, False),
        ("≤ 90 ms", 130.0, None, True),
        ("< 50 ms", 50.0, None, True),
        ("≤ 250 ms, with the screen", 124.0, None, False),
        ("± 5 %", -5.5, None, True),
        ("± 5 %", -1.0, None, False),
        ("ratio ≤ 1.25", 4.5, 1.35, True),
        ("ratio ≤ 1/15", 16.0, 0.055, False),
        ("ratio ≤ 1/15", 16.0, 0.07, True),
        ("flat", 0.03, None, False),
        ("", 3.0, None, False),
    ],
)
def test_a_goal_is_missed_where_its_number_is_passed(
    goal: str, value: float, ratio: float | None, missed: bool
) -> None:
    assert is_missed(goal, value, ratio) is missed


def test_a_row_marks_a_missed_goal_and_one_that_is_not_measured_says_so() -> None:
    measured = {"value": 130.0, "ratio": None, "date": "2026-01-01", "commit": "c", "machine": "m"}
    row = {"work": "a step", "unit": "ms", "goal": "≤ 90 ms", "peer": ""}
    cells = line(row | {"measured": measured}, "1.0").split(" | ")
    assert (cells[1], cells[3], cells[5]) == ("130 ms", "≤ 90 ms: **missed**", "2026-01-01, c, m |\n")
    cells = line(row, "1.0").split(" | ")
    assert (cells[3], cells[5]) == ("≤ 90 ms", "not yet |\n")


def test_the_document_is_that_of_the_figures() -> None:
    assert TABLE.read_text(encoding="utf-8") == table(json.loads(DATA.read_text(encoding="utf-8")))


@pytest.mark.parametrize(("release", "cell"), [(NONE_YET, "\N{EN DASH}"), ("1.0", "120 ms (1.0)")])
def test_the_document_says_where_there_is_no_release(release: str, cell: str) -> None:
    row = {"work": "a step", "unit": "ms", "goal": "", "peer": ""} | ({} if release == NONE_YET else {"release": 120.0})
    text = table({"release": release, "rows": {"mission.step": row}})
    assert (NO_RELEASE in text) is (release == NONE_YET)
    assert text.endswith(f"| {cell} | not yet |\n")
