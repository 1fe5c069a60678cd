"""AOS-APSO: AOS-PSO whose factors follow the state of the search.

Source: AOS-APSO paper, section Adaptive PSO strategy for AOS drone swarms, and for the untuned form section Results;
algorithms.md section 3e.
"""

from __future__ import annotations

from collections.abc import Mapping

from aos_gcs.swarm.evolution import FractionalFactors
from aos_gcs.swarm.factors import ApsoRule, FractionalRule
from aos_gcs.swarm.follow import LeaderFollowing
from aos_gcs.swarm.parameters import AosApsoParameters, AosApsoUntunedParameters, parse_parameters

NAME = "aos-apso"
UNTUNED_NAME = "aos-apso-untuned"


def make_aos_apso(parameters: Mapping[str, object]) -> LeaderFollowing:
    """Return AOS-APSO with the parameters given (:class:`AosApsoParameters`) and defaults for the rest.

    Raises:
        ConfigurationError: a parameter is unknown or violates its constraint.
    """
    chosen = parse_parameters(AosApsoParameters, parameters, NAME)
    initial = FractionalFactors(chosen.initial_c_s_hat, chosen.initial_c_c_hat)
    rule = FractionalRule(chosen.c4_m, initial, chosen.gamma, chosen.min_factor, chosen.max_factor)
    return LeaderFollowing(NAME, chosen, rule)


def make_aos_apso_untuned(parameters: Mapping[str, object]) -> LeaderFollowing:
    """Return AOS-APSO with APSO's own adaptation (:class:`AosApsoUntunedParameters`), the rest equal.

    Raises:
        ConfigurationError: a parameter is unknown or violates its constraint.
    """
    chosen = parse_parameters(AosApsoUntunedParameters, parameters, UNTUNED_NAME)
    return LeaderFollowing(UNTUNED_NAME, chosen, ApsoRule(chosen.c4_m))
