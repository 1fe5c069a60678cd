"""AOS-PSO: a drone swarm that samples around the drone with the best view.

Source: Nathan, Kurmi and Bimber, Communications Engineering 2:55 (2023), as in the AOS-APSO paper
(``alg:pso-for-aos``). The stabilised form is the paper's own.
"""

from __future__ import annotations

from collections.abc import Mapping

from aos_gcs.swarm.factors import FixedFactors
from aos_gcs.swarm.follow import LeaderFollowing
from aos_gcs.swarm.parameters import AosPsoParameters, AosPsoStabilisedParameters, parse_parameters

NAME = "aos-pso"
STABILISED_NAME = "aos-pso-stabilised"


def make_aos_pso(parameters: Mapping[str, object]) -> LeaderFollowing:
    """Return AOS-PSO with the parameters given (:class:`AosPsoParameters`) and defaults for the rest.

    Raises:
        ConfigurationError: a parameter is unknown or violates its constraint.
    """
    return _with_fixed_factors(NAME, parse_parameters(AosPsoParameters, parameters, NAME))


def make_aos_pso_stabilised(parameters: Mapping[str, object]) -> LeaderFollowing:
    """Return AOS-PSO with leader stabilisation and line positions by projection; parameters as for AOS-PSO.

    Raises:
        ConfigurationError: a parameter is unknown or violates its constraint.
    """
    return _with_fixed_factors(
        STABILISED_NAME, parse_parameters(AosPsoStabilisedParameters, parameters, STABILISED_NAME)
    )


def _with_fixed_factors(name: str, parameters: AosPsoParameters) -> LeaderFollowing:
    return LeaderFollowing(name, parameters, FixedFactors(parameters.c_s_m, parameters.c_c_m))
