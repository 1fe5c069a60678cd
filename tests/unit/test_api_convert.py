"""Conversions hand out the same objects again for what has not changed, and never old ones for what has."""

from __future__ import annotations

from dataclasses import dataclass

from aos_gcs.api.convert.reuse import Reused, ReusedItems


@dataclass(frozen=True)
class Input:
    name: str


class Output:
    def __init__(self, value: Input) -> None:
        self.name = value.name


def test_an_equal_value_is_converted_once() -> None:
    convert = Reused(Output)
    first = convert(Input("a"))
    assert convert(Input("a")) is first
    assert convert(Input("b")).name == "b"
    assert convert(Input("a")).name == "a"


def test_only_changed_items_are_converted_again() -> None:
    convert = ReusedItems(Output)
    first = convert((Input("a"), Input("b"), Input("c")))
    second = convert((Input("a"), Input("x"), Input("c")))
    assert second[0] is first[0]
    assert second[1].name == "x"
    assert second[2] is first[2]


def test_lists_grow_shrink_and_come_back() -> None:
    convert = ReusedItems(Output)
    for names in ("", "ab", "abc", "b", "", "cab"):
        assert [one.name for one in convert(tuple(map(Input, names)))] == list(names)
