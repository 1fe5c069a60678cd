"""The smallest part of a scenario that fails in the same way."""

from __future__ import annotations

from tests.campaign.flight import FlightVerdict, fly


def shrink(verdict: FlightVerdict) -> FlightVerdict:
    """Drop one fault after the other for as long as a violation of the same kind is left."""
    kinds = {violation.kind for violation in verdict.violations}
    for fault in verdict.scenario.faults:
        smaller = fly(verdict.scenario.without(fault))
        if kinds & {violation.kind for violation in smaller.violations}:
            return shrink(smaller)
    return verdict
