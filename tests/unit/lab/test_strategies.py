"""Names of strategies in a list."""

import pytest

from aos_gcs.errors import ConfigurationError
from aos_gcs.lab.strategies import StrategyChoice, parse_strategies


def test_names_and_parameters() -> None:
    text = "aos-pso, aos-apso(gamma=0.8,min_factor = 0.25) ,aos-pso(leader_stabilised=true, repulsion_cutoff_m=null)"
    assert parse_strategies(text) == (
        StrategyChoice("aos-pso"),
        StrategyChoice("aos-apso", {"gamma": 0.8, "min_factor": 0.25}),
        StrategyChoice("aos-pso", {"leader_stabilised": True, "repulsion_cutoff_m": None}),
    )


def test_the_label_of_a_choice_names_the_same_choice() -> None:
    choices = parse_strategies("aos-apso(min_factor=0.25,gamma=0.8),aos-pso(),aos-pso(leader_stabilised=true)")
    labels = [choice.label for choice in choices]
    assert labels == ["aos-apso(gamma=0.8, min_factor=0.25)", "aos-pso", "aos-pso(leader_stabilised=true)"]
    assert parse_strategies(",".join(labels)) == choices


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("aos-pso,nonsense", "no strategy 'nonsense'"),
        ("", "strategies cannot be read"),
        ("aos-pso,", "strategies cannot be read"),
        ("aos-pso(c_s_m=2", "strategies cannot be read"),
        ("aos-pso aos-apso", "strategies cannot be read"),
        ("aos-pso(2.0)", "must be name=value"),
        ("aos-pso(c_s_m=1 2)", "c_s_m of aos-pso must be a number, true, false or a word"),
        ("aos-pso(c_s_m=2.0,c_s_m=2.5)", "given twice"),
        ("aos-pso(speed=3)", "no parameter speed"),
        ("aos-pso(c_s_m=0.5)", "c_s_m must be above c_c_m"),
        ("aos-pso(c_s_m=4.0)", "c_s_m \\+ c_c_m must be at most c4_m"),
        ("aos-pso,aos-pso()", "names aos-pso twice"),
    ],
)
def test_refusals(text: str, words: str) -> None:
    with pytest.raises(ConfigurationError, match=words):
        parse_strategies(text)
