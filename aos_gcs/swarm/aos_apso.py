"""AOS-APSO: AOS-PSO whose factors follow the state of the search.

Source: AOS-APSO paper, section Adaptive PSO strategy for AOS drone swarms, and for the untuned form section Results.
"""

from __future__ import annotations

from collections.abc import Mapping

from aos_gcs.swarm.archive.parameters import AosApsoParameters
from aos_gcs.swarm.archive.strategy import ViewKeeping, view_keeping
from aos_gcs.swarm.factors import ApsoRule, fractional_rule
from aos_gcs.swarm.follow import LeaderFollowing
from aos_gcs.swarm.parameters import AosApsoPaperParameters, AosApsoUntunedParameters, parse_parameters

NAME = "aos-apso"
PAPER_NAME = "aos-apso-paper"
UNTUNED_NAME = "aos-apso-untuned"


def make_aos_apso(parameters: Mapping[str, object]) -> ViewKeeping:
    """Return AOS-APSO with the parameters given (:class:`AosApsoParameters`) and defaults for the rest.

    Its adaptive step keeps every view of the target and holds those that show most of it together.

    Raises:
        ConfigurationError: a parameter is unknown or violates its constraint.
    """
    return view_keeping(NAME, parse_parameters(AosApsoParameters, parameters, NAME))


def make_aos_apso_paper(parameters: Mapping[str, object]) -> LeaderFollowing:
    """Return AOS-APSO with the paper's step, with the parameters given (:class:`AosApsoPaperParameters`).

    Raises:
        ConfigurationError: a parameter is unknown or violates its constraint.
    """
    chosen = parse_parameters(AosApsoPaperParameters, parameters, PAPER_NAME)
    return LeaderFollowing(PAPER_NAME, chosen, fractional_rule(chosen))


def make_aos_apso_untuned(parameters: Mapping[str, object]) -> LeaderFollowing:
    """Return AOS-APSO with APSO's own adaptation (:class:`AosApsoUntunedParameters`), the rest equal.

    Raises:
        ConfigurationError: a parameter is unknown or violates its constraint.
    """
    chosen = parse_parameters(AosApsoUntunedParameters, parameters, UNTUNED_NAME)
    return LeaderFollowing(UNTUNED_NAME, chosen, ApsoRule(chosen.c4_m))
