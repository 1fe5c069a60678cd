"""Strategies by name, from the entry points of the group ``aos_gcs.strategies``."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from aos_gcs.errors import ConfigurationError
from aos_gcs.swarm.declaration import Parameter, parameters_of
from aos_gcs.swarm.lone import LoneLook
from aos_gcs.swarm.model import Strategy
from aos_gcs.swarm.parameters import LineParameters, StrategyParameters

GROUP = "aos_gcs.strategies"


def available_strategies() -> tuple[str, ...]:
    """Return the names of all installed strategies, sorted."""
    return tuple(sorted(entry_points(group=GROUP).names))


def make_strategy(name: str, parameters: Mapping[str, object]) -> Strategy[Any]:
    """Return the strategy of that name.

    An entry point is a callable that takes the parameters, as here, and returns a
    :class:`~aos_gcs.swarm.model.Strategy`.

    Raises:
        ConfigurationError: the name is unknown, the package behind it cannot be imported, or a parameter is unknown or
            violates its constraint.
    """
    try:
        make = _entry_point(name).load()
    except (ImportError, AttributeError) as error:
        raise ConfigurationError(f"The strategy {name!r} cannot be loaded ({error}); install its package.") from error
    strategy: Strategy[Any] = make(parameters)
    return strategy


def strategy_for(vehicles: int, name: str, parameters: Mapping[str, object]) -> Strategy[Any]:
    """Return the strategy of that name for a number of vehicles; a single one has a close look of its own.

    Raises:
        ConfigurationError: as for :func:`make_strategy`.
    """
    strategy = make_strategy(name, parameters)
    if vehicles > 1:
        return strategy
    own = getattr(strategy, "parameters", None)
    step_m = own.c3_m if isinstance(own, LineParameters) else LineParameters().c3_m
    return LoneLook(name, strategy.spacing_m, step_m)


def declared_parameters(name: str) -> tuple[Parameter, ...]:
    """Return what can be chosen about a strategy; nothing of one that does not keep it in :class:`StrategyParameters`.

    Raises:
        ConfigurationError: the name is unknown, or the package behind it cannot be imported.
    """
    parameters: object = getattr(make_strategy(name, {}), "parameters", None)
    return parameters_of(type(parameters)) if isinstance(parameters, StrategyParameters) else ()


@cache
def _entry_point(name: str) -> EntryPoint:
    """Return what is installed under a name; remembered, since looking takes milliseconds."""
    found = tuple(entry_points(group=GROUP, name=name))
    if not found:
        raise ConfigurationError(f"There is no strategy {name!r}; choose one of {', '.join(available_strategies())}.")
    return found[0]
