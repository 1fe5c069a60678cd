"""Strategies by name, their parameters' constraints, and saving states."""

import json
from importlib.metadata import EntryPoint

import numpy as np
import pytest

from aos_gcs.errors import ConfigurationError
from aos_gcs.swarm import registry
from aos_gcs.swarm.follow import LeaderFollowing
from aos_gcs.swarm.parameters import AosApsoPaperParameters
from aos_gcs.swarm.registry import available_strategies, make_strategy
from aos_gcs.swarm.state import dump_rng
from tests.fakes.generators import load_rng


def test_the_strategies_of_the_paper_are_registered() -> None:
    papers = {
        "blind-sequential",
        "blind-parallel",
        "aos-pso",
        "aos-pso-stabilised",
        "aos-apso-paper",
        "aos-apso-untuned",
    }
    assert papers <= set(available_strategies())
    for name in papers:
        assert make_strategy(name, {}).name == name


def test_an_unknown_name_lists_the_known_ones() -> None:
    with pytest.raises(ConfigurationError, match=r"no strategy 'pso'.*aos-apso, .*aos-pso"):
        make_strategy("pso", {})


def test_a_strategy_whose_package_is_missing_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    broken = EntryPoint("broken", "no_such_package:make", registry.GROUP)
    monkeypatch.setattr(registry, "entry_points", lambda **_: (broken,))
    with pytest.raises(ConfigurationError, match=r"'broken' cannot be loaded"):
        make_strategy("broken", {})


def test_parameters_reach_the_strategy() -> None:
    strategy = make_strategy("aos-apso-paper", {"c4_m": 5, "gamma": 0.8, "leader_stabilised": False})
    assert isinstance(strategy, LeaderFollowing)
    assert isinstance(strategy.parameters, AosApsoPaperParameters)
    assert (strategy.parameters.c4_m, strategy.parameters.gamma) == (5.0, 0.8)
    assert not strategy.parameters.leader_stabilised
    assert strategy.spacing_m == 5.0


@pytest.mark.parametrize(
    ("name", "parameters", "text"),
    [
        ("aos-pso", {"gamma": 0.9}, "has no parameter gamma"),
        ("aos-pso", {"c_s_m": "2"}, "c_s_m .*must be a number"),
        ("aos-pso", {"c_s_m": True}, "c_s_m .*must be a number"),
        ("aos-pso", {"c3_m": None}, "c3_m .*must be a number"),
        ("aos-pso", {"projection_line": 1}, "projection_line .*true or false"),
        ("aos-pso", {"c_s_m": 1.0}, r"c_s > c_c"),
        ("aos-pso", {"c_s_m": 3.3}, r"c_s \+ c_c <= c4"),
        ("aos-pso", {"c_c_m": 0.0}, "c_c_m must be above 0"),
        ("aos-pso", {"c3_m": 0.0}, "c3_m must be above 0"),
        ("aos-pso", {"c4_m": -1.0}, "c4_m must be above 0"),
        ("aos-pso", {"c4_m": float("nan")}, "c4_m must be a finite"),
        ("aos-pso", {"c5": 1.5}, "c5 must be above 0 and at most 1"),
        ("aos-pso", {"repulsion_cutoff_m": 0.0}, "repulsion_cutoff_m must be above 0"),
        ("aos-pso", {"revisit_radius_m": -1.0}, "revisit_radius_m must be above 0"),
        ("aos-pso", {"personal_best_memory": "yes"}, "personal_best_memory .*true or false"),
        ("aos-pso-stabilised", {"c_s_m": 1.0}, r"c_s > c_c"),
        ("aos-apso-untuned", {"gamma": 0.9}, "has no parameter gamma"),
        ("blind-parallel", {"leader_stabilised": True}, "has no parameter leader_stabilised"),
        ("blind-parallel", {"c5": 0.0}, "c5 must be above 0"),
        ("blind-sequential", {"width_m": -1.0}, "width_m must be at least 0"),
        ("blind-sequential", {"c4_m": 0.0}, "c4_m must be above 0"),
        ("aos-apso", {"c_s_m": 2.0}, "has no parameter c_s_m"),
        ("aos-apso", {"gamma": 1.0}, "gamma must be above 0 and below 1"),
        ("aos-apso", {"min_factor": 0.6, "max_factor": 0.5}, "min_factor must be below max_factor"),
        ("aos-apso", {"min_factor": 0.7}, "below 0.618"),
        ("aos-apso", {"initial_c_s_hat": 1.0}, "initial_c_s_hat must be above 0 and below 1"),
        ("aos-apso", {"min_factor": 0.55}, "initial_c_s_hat must lie"),
        ("aos-apso", {"initial_c_s_hat": 0.8}, r"c_s \+ c_c <= c4"),
    ],
)
def test_violations_name_field_and_constraint(name: str, parameters: dict[str, object], text: str) -> None:
    with pytest.raises(ConfigurationError, match=text):
        make_strategy(name, parameters)


def test_generators_survive_json() -> None:
    rng = np.random.default_rng(3)
    rng.uniform(size=5)
    again = load_rng(json.loads(json.dumps(dump_rng(rng))))
    assert np.array_equal(rng.uniform(size=9), again.uniform(size=9))


def test_a_generator_whose_state_json_does_not_hold_is_refused() -> None:
    with pytest.raises(ValueError, match="PCG64"):
        dump_rng(np.random.Generator(np.random.MT19937(0)))
