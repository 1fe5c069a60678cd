"""A campaign: several strategies through many initialisations of one scenario."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

import pyarrow as pa

from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.lab.bound import oracle_rows
from aos_gcs.lab.experiment import run_strategy
from aos_gcs.lab.initialisation import Initialisation, check_initialisation, open_world
from aos_gcs.lab.scenario import Scenario, parse_scenario
from aos_gcs.lab.strategies import StrategyChoice
from aos_gcs.lab.tables import SCHEMA, to_table

FORMAT = 1
"""Version of the manifest and the result files."""


@dataclass(frozen=True, slots=True)
class Campaign:
    """Scenario, strategies and initialisations of one comparison.

    Equal campaigns of one version of the program have equal results.

    Raises:
        ConfigurationError: nothing to do, or an initialisation that does not fit the scenario.
    """

    scenario: Scenario
    strategies: tuple[StrategyChoice, ...]
    initialisations: tuple[Initialisation, ...]
    oracle: bool = False
    """Whether the rows hold what the best positions would show, too (:mod:`aos_gcs.lab.bound`)."""

    def __post_init__(self) -> None:
        if not self.strategies or not self.initialisations:
            raise ConfigurationError("A campaign needs strategies and initialisations, one of each at least.")
        for initialisation in self.initialisations:
            check_initialisation(initialisation, self.scenario)

    def manifest(self) -> dict[str, Any]:
        """Return everything that decides the results, as data for JSON."""
        settings = {
            "format": FORMAT,
            "version": version("aos-gcs"),
            "oracle": self.oracle,
            "scenario": dataclasses.asdict(self.scenario),
            "strategies": [dataclasses.asdict(choice) for choice in self.strategies],
            "initialisations": [dataclasses.asdict(initialisation) for initialisation in self.initialisations],
        }
        # Once through JSON, so that what is compared with a file looks like what comes out of one.
        plain: dict[str, Any] = json.loads(json.dumps(settings))
        return plain

    @property
    def digest(self) -> str:
        """Hash of the manifest, which the result files carry."""
        return hashlib.sha256(json.dumps(self.manifest(), sort_keys=True).encode()).hexdigest()


def parse_manifest(manifest: Mapping[str, Any], source: str) -> Campaign:
    """Return the campaign of a manifest.

    Raises:
        InputDataError: it is of another format or incomplete.
    """
    if manifest.get("format") != FORMAT:
        raise InputDataError(
            f"{source} has format {manifest.get('format')!r}, this program reads {FORMAT}; run the campaign again."
        )
    try:
        return Campaign(
            parse_scenario(manifest["scenario"]),
            tuple(StrategyChoice(**choice) for choice in manifest["strategies"]),
            tuple(
                Initialisation(**{**fields, "target_offset_m": tuple(fields["target_offset_m"])})
                for fields in manifest["initialisations"]
            ),
            oracle=manifest["oracle"],
        )
    except (KeyError, TypeError, AttributeError, ConfigurationError) as error:
        raise InputDataError(f"{source} is not the manifest of a campaign ({error}).") from error


def run_initialisation(campaign: Campaign, initialisation: Initialisation) -> pa.Table:
    """Return the rows of all strategies in one initialisation, whose forest is built once."""
    scenario = campaign.scenario
    world = open_world(initialisation, scenario)
    tables = [
        to_table(run_strategy(world, scenario, initialisation, choice.make(), choice.label))
        for choice in campaign.strategies
    ]
    if campaign.oracle:
        tables.append(to_table(oracle_rows(world, scenario, initialisation)))
    return pa.concat_tables([SCHEMA.empty_table(), *tables]).combine_chunks()
