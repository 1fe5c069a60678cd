"""Options of ``aos-gcs lab search``."""

from __future__ import annotations

from typing import get_type_hints

from aos_gcs.cli.lab.search import search
from aos_gcs.lab.search.model import Method


def test_help_names_every_flight_in_its_order() -> None:
    (option,) = get_type_hints(search, include_extras=True)["methods"].__metadata__
    assert option.help == f"Flights: {', '.join(Method)}, separated by commas."
