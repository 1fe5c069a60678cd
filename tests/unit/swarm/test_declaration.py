"""Declarations of the parameters of strategies."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import pytest

from aos_gcs.errors import ParameterError
from aos_gcs.swarm.archive.parameters import AosApsoParameters
from aos_gcs.swarm.declaration import Bounds, declared, parameters_of
from aos_gcs.swarm.parameters import AosPsoParameters, SwarmParameters
from aos_gcs.swarm.registry import available_strategies, declared_parameters


@dataclass(frozen=True, slots=True, kw_only=True)
class Base:
    reach_m: float = declared(2.0, "How far.", above=0.0, at_most=9.0)
    limit: float | None = declared(None, "Off if empty.", at_least=1.0)
    loud: bool = declared(False, "Makes noise.")
    undeclared: float = 3.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Derived(Base):
    loud: bool = True


def test_a_declaration_says_all_that_a_form_needs() -> None:
    reach, limit, loud, undeclared = parameters_of(Base)
    assert (reach.name, reach.default, reach.unit, reach.text) == ("reach_m", 2.0, "m", "How far.")
    assert str(reach.bounds) == "above 0 and at most 9"
    assert (limit.is_optional, limit.default, limit.unit) == (True, None, "")
    assert (loud.is_switch, loud.default) == (True, False)
    assert (undeclared.text, undeclared.bounds) == ("", Bounds())


def test_another_default_keeps_the_declaration() -> None:
    loud = next(parameter for parameter in parameters_of(Derived) if parameter.name == "loud")
    assert (loud.default, loud.text) == (True, "Makes noise.")
    assert Derived().loud


def test_values_are_converted_or_refused_with_their_name() -> None:
    reach, limit, loud, _ = parameters_of(Base)
    assert reach.converted(9) == 9.0
    assert limit.converted(None) is None
    for parameter, value in ((reach, 0.0), (reach, 9.5), (reach, True), (reach, None), (limit, 0.5), (loud, 1)):
        with pytest.raises(ParameterError, match=parameter.name) as refused:
            parameter.converted(value)
        assert refused.value.parameter == parameter.name


@pytest.mark.parametrize("name", available_strategies())
def test_every_strategy_explains_its_parameters_and_takes_its_defaults(name: str) -> None:
    parameters = declared_parameters(name)
    assert {"c4_m"} <= {parameter.name for parameter in parameters}
    for parameter in parameters:
        assert parameter.text.endswith(".")
        assert parameter.converted(parameter.default) == parameter.default


@pytest.mark.parametrize(
    ("make", "parameter"),
    [
        (lambda: AosPsoParameters(c_s_m=0.5), "c_s_m"),
        (lambda: AosApsoParameters(min_factor=0.6, max_factor=0.5), "min_factor"),
        (lambda: AosApsoParameters(min_factor=0.55), "initial_c_s_hat"),
        (lambda: SwarmParameters(c5=float("nan")), "c5"),
    ],
)
def test_constraints_between_parameters_name_the_one_to_change(make: Callable[[], object], parameter: str) -> None:
    with pytest.raises(ParameterError) as refused:
        make()
    assert refused.value.parameter == parameter
