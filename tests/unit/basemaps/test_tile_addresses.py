"""Addresses and areas of a server's tiles, before anything is asked."""

from __future__ import annotations

import pytest

from aos_gcs.basemaps.downloading import MAX_TILES, TileArea
from aos_gcs.basemaps.tiles.addresses import TileTemplate
from aos_gcs.errors import ConfigurationError

HOST = "https://tiles.example.org"


def test_rows_are_counted_from_the_north_or_from_the_south() -> None:
    assert TileTemplate.parsed(f"{HOST}/{{z}}/{{x}}/{{y}}.png").address(3, 2, 1) == f"{HOST}/3/2/1.png"
    assert TileTemplate.parsed(f"{HOST}/t?m={{z}}&c={{x}}&r={{-y}}").address(3, 2, 1) == f"{HOST}/t?m=3&c=2&r=6"


@pytest.mark.parametrize(
    ("address", "reason"),
    [
        (f"{HOST}/{{z}}/{{x}}.png", "needs the placeholders"),
        (f"{HOST}/{{x}}/{{y}}.png", "needs the placeholders"),
        (f"{HOST}/{{z}}/{{x}}/{{y}}/{{-y}}.png", "needs the placeholders"),
        ("https://{s}.example.org/{z}/{x}/{y}.png", r"unknown placeholder \{s\}"),
        (f"{HOST}/{{z}}/{{x}}/{{y}}{{r}}.png", r"unknown placeholder \{r\}"),
        ("https://{z}.example.org/{x}/{y}.png", "begins with https"),
        ("file:///tiles/{z}/{x}/{y}.png", "begins with https"),
        ("tiles.example.org/{z}/{x}/{y}.png", "begins with https"),
        ("https:///{z}/{x}/{y}.png", "begins with https"),
        ("https://host:99999/{z}/{x}/{y}.png", "begins with https"),
        ("https://[host/{z}/{x}/{y}.png", "begins with https"),
        (f"{HOST}/{{z}}/{{x}}/{{y}}.png\n", "begins with https"),
    ],
)
def test_what_is_no_address_of_tiles_is_refused_without_repeating_it(address: str, reason: str) -> None:
    with pytest.raises(ConfigurationError, match=reason) as caught:
        TileTemplate.parsed(f"{address}?key=s3cret")
    assert "s3cret" not in str(caught.value)


def test_a_key_is_neither_shown_nor_part_of_what_an_address_is_known_by() -> None:
    template = TileTemplate.parsed("https://user:s3cret@tiles.example.org/s3cret/{z}/{x}/{y}.png?key=s3cret")
    assert "s3cret" not in f"{template!r}{template}{template.fingerprint}{template.host}"
    assert template.host == "tiles.example.org"


def test_an_area_has_the_tiles_that_have_a_part_of_it() -> None:
    area = TileArea.checked((14.2, 47.4, 14.3, 47.5), 0, 12)
    assert area.count == len(set(area.places()))
    assert [place for place in area.places() if place[0] < 4] == [(0, 0, 0), (1, 1, 0), (2, 2, 1), (3, 4, 2)]
    assert {place[1:] for place in area.places() if place[0] == 12} == {
        (x, y) for x in (2209, 2210) for y in (1432, 1433)
    }
    assert TileArea.checked((-180.0, -85.05, 180.0, 85.05), 3, 3).count == 64


@pytest.mark.parametrize(
    ("degrees", "zooms", "reason"),
    [
        ((14.3, 47.4, 14.2, 47.5), (1, 2), "west,south,east,north"),
        ((14.2, 47.5, 14.3, 47.4), (1, 2), "west,south,east,north"),
        ((14.2, 47.4, 14.3, 86.0), (1, 2), "west,south,east,north"),
        ((170.0, 47.4, 190.0, 48.0), (1, 2), "west,south,east,north"),
        ((14.2, 47.4, 14.3, 47.5), (3, 2), "smaller first"),
        ((14.2, 47.4, 14.3, 47.5), (3, 23), "within 0 to 22"),
        ((14.0, 47.0, 15.0, 48.0), (10, 17), f"{MAX_TILES:,} are allowed"),
    ],
)
def test_what_is_no_area_or_has_too_many_tiles_is_refused(
    degrees: tuple[float, float, float, float], zooms: tuple[int, int], reason: str
) -> None:
    with pytest.raises(ConfigurationError, match=reason):
        TileArea.checked(degrees, *zooms)
