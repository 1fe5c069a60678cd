"""The one decision: what something is that a swarm has seen, how probably a person, and why.

It rests on two things: how warm a body is, by a model of temperatures on days that differ (:mod:`classifier
<aos_gcs.imaging.persons.classifier>`), and its size and pattern of warmth, which are the same on any day (:mod:`kinds
<aos_gcs.imaging.persons.kinds>`). The latter counts in full once enough vantage points tell it.

Missions, their findings and notices, the score of simulated missions, and the study of effectiveness all call
:func:`decide` on :class:`~aos_gcs.imaging.persons.evidence.Evidence`; none has a rule of its own. What is
looked at again and again is decided by :func:`pooled`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import scipy

from aos_gcs.imaging.persons.classifier import (
    MAX_CONTRAST_K,
    MIN_VEHICLES,
    SKIN_C,
    PersonModel,
    hotter_than_usual_k,
    person_confidence,
)
from aos_gcs.imaging.persons.evidence import Evidence
from aos_gcs.imaging.persons.form import Form
from aos_gcs.imaging.persons.kinds import log_ratio

DECISION = 0.5
"""Probability from which a body counts as a person."""
TOGETHER = 0.6
"""Probability from which several looks together are of a person, once the look at it is over."""
AT_ONCE = 0.8
"""Probability from which a person is announced before that: of a hot stone or an animal that is looked at for minutes,
the worst moment counts."""
AT_LAST = 0.35
"""Probability from which a body that was looked at, and not decided, is announced when the search ends: no further look
is to come, and to miss a person costs more than to walk to a stone."""
SURELY_OTHER = 0.01
"""Probability up to which a body that most vehicles see needs no longer look."""
MOST = 0.6
"""Share of the vehicles that are most of them."""
ENOUGH = 3
"""Vehicles that must see it for that."""
THOROUGH_FRAMES = 9
"""Frames that show a body thoroughly: those of three vehicles in three steps."""
SMEARED_PERSON_K = 11.0
"""Peak contrast from which something that was seen in flight alone may be a person: of clothes 13 K warmer than their
surroundings frames taken at 5 m/s show 13 K somewhere, but 7 K in the middle, as of fur."""
_SMEARED_LEAST_K = 7.0
"""Least such contrast, in a forest so warm that skin stands out of it by less than 13 K."""
_SMEARED_SHARE = 0.55
"""Such a contrast as a share of that of skin."""
MIN_RELATIVE_CONTRAST = 5.0
"""Median contrast of a spot without temperatures that counts as a find, in standard deviations of its surroundings."""
MIN_CONCENTRATION = 4.0
"""Density of pixels that stand out at such a spot, as a multiple of that around it."""
COVERED_SHARE = 0.05
"""Share of persons of whom no skin shows however often they are looked at: hood, gloves, and a cloth over the face or
the face to the ground. An assumption."""
HIDDEN_SHARE = 0.3
"""Share of looks at other persons in which leaves hide all skin: 8 of 27 in simulated forests, 300 to 500 trees/ha."""
FRESH_LOOKS = 3
"""Looks of which the first and the last have no frame in common: each rests on those of three steps."""
FORM_TOLD = 6
"""Vantage points from which on a form is told, so that a person may be announced by it. Fewer count less: frames that
show a part of an animal each may make it a person's."""
_WARMTH_BESIDE_FORM = 0.4
"""Weight of the log-odds by temperatures of all looks beside a form that they tell: temperatures of a day differ from
those that the model is fitted to, sizes do not. Of a single look, few frames tell the form, and it is 1."""
SEVERAL_LOOKS = 1.5
"""Weight of the log-odds of many looks in the probability that is stated of a person, over that of a single look: what
leaves hide differs between looks, and what errs in all of them alike does not. Chosen on 115 simulated missions,
without skin to be seen and with blurred optics."""
_TOLD_HEIGHT_M2 = 0.05
"""Standard deviation of the variance of heights up to which a height is told: 0.4 m of a standing person's."""
_SUREST_LOG_ODDS = 5.0
"""Log-odds above which, on either side, one of several looks counts no more: none outweighs all the others."""
_FUR_SPREAD_K = 2.5
"""Contrast of the warmest parts above the middle from which a warm body is rather an animal (head and legs are warmer
than fur) than a stone (warm all over)."""


class FindingKind(StrEnum):
    """What something that was seen is taken for."""

    UNDECIDED = "undecided"
    """Not decided yet, or marked by an operator."""
    PERSON = "person"
    ANIMAL = "animal"
    WARM_OBJECT = "warm_object"
    OBJECT = "object"
    """Unlike its surroundings, but no warmer."""
    ANOMALY = "anomaly"
    """Stands out of its surroundings in frames without temperatures, which cannot tell what it is."""


CLAIMED = frozenset({FindingKind.PERSON, FindingKind.ANOMALY})
"""Kinds that searchers are told of as a find: what cannot be judged counts as a person would."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """Decision about one body."""

    kind: FindingKind
    probability: float | None
    """Probability, 0 to 1, that it is a person; None without temperatures, as the model of persons needs them."""
    reasons: tuple[str, ...]
    """What it rests on, in words."""
    is_surely_other: bool = False
    """Whether it is no person by what most of the vehicles see: nothing that leaves hide could change that."""
    is_thorough: bool = False
    """Whether so many frames show that it is surely no person that further looks would tell no more. What is not warm
    is never: leaves may hide a person from all of them but one."""
    is_evidence: bool = True
    """Whether it counts beside other looks; what a single vehicle sees does not, nor what frames taken in flight show
    too cool for a person."""
    is_uniform: bool = False
    """Whether it is equally warm all over, as a stone is, so that no skin shows."""
    by_warmth: float | None = None
    """Probability by temperatures alone; None where it is the same."""
    is_sure: bool = False
    """Whether several looks are in the mean so surely of a person that no more of them are awaited."""


def decide(evidence: Evidence, model: PersonModel | None = None) -> Verdict:
    """Return what a body is taken for; ``model`` None: the one that comes with the program.

    Without temperatures there is no probability: a spot that stands out at its place counts as a find, as a person
    would, and one that does not is an object.
    """
    if not evidence.radiometric:
        return _without_temperatures(evidence)
    if evidence.views == 0:
        reason = f"not warmer than its surroundings in {evidence.frames} frames"
        return Verdict(FindingKind.OBJECT, 0.0, (reason,), is_surely_other=evidence.swarm >= ENOUGH)
    by_warmth = person_confidence(evidence, model)
    is_judged_by_form = evidence.form is not None and by_warmth > 0.0
    probability = _with_form(_log_odds(by_warmth), evidence.form) if is_judged_by_form else by_warmth
    share = evidence.vehicles / max(evidence.swarm, evidence.vehicles)
    may_be_more = may_be_warmer(evidence)
    is_seen_by_most = share >= MOST and evidence.vehicles >= ENOUGH
    is_surely_other = probability <= SURELY_OTHER and is_seen_by_most and not may_be_more
    return Verdict(
        _kind(evidence, probability),
        probability,
        _reasons(evidence),
        is_surely_other=is_surely_other,
        is_thorough=is_surely_other and evidence.views >= max(THOROUGH_FRAMES, MOST * evidence.frames),
        is_evidence=evidence.vehicles >= MIN_VEHICLES and not (evidence.is_smeared and probability < DECISION),
        is_uniform=evidence.contrast_peak_k - evidence.contrast_median_k < _FUR_SPREAD_K,
        by_warmth=by_warmth,
    )


def may_be_warmer(evidence: Evidence) -> bool:
    """Return whether frames that were taken in flight, and smear, may show something as warm as a person."""
    limit_k = SMEARED_PERSON_K
    if evidence.background_c is not None:
        # On a clear day, in a forest of 17 °C, frames in flight show a person at 9 K.
        limit_k = min(limit_k, max(_SMEARED_LEAST_K, _SMEARED_SHARE * (SKIN_C - evidence.background_c)))
    return evidence.is_smeared and evidence.contrast_peak_k >= limit_k


def pooled(verdicts: Sequence[Verdict], form: Form | None = None) -> Verdict:
    """Return the decision about a body that was looked at several times, at least once; the latest verdict is the last.

    The mean of the log-odds decides: a look that leaves spoil neither makes nor breaks a person. A person is stated
    more surely than by the mean, the more looks there are (:data:`SEVERAL_LOOKS`).
    The more looks there are, none of which shows skin, the lower it is: leaves may hide hands and face in one look, but
    hardly in all of them, and a stone in the sun is as warm as clothes in each. Below :data:`TOGETHER` it is what the
    latest look that sees something else takes it for, or undecided where none does. Without temperatures, and where no
    look is evidence, the latest one decides.

    Args:
        verdicts: of the looks.
        form: size and pattern of warmth by all looks; None where too few frames tell it.
    """
    latest, looks = verdicts[-1], telling(verdicts)
    if latest.probability is None or not looks:
        return latest
    log_odds = sum(_log_odds(_by_warmth(one)) for one in looks) / len(looks)
    probability = _with_form(log_odds, form, _log_ratio_without_skin(looks), beside_form=_WARMTH_BESIDE_FORM)
    is_person = probability >= TOGETHER
    decisive = [one for one in looks if (one.kind is FindingKind.PERSON) is is_person]
    otherwise = FindingKind.PERSON if is_person else FindingKind.UNDECIDED
    verdict = decisive[-1] if decisive else replace(looks[-1], kind=otherwise)
    is_surely_other = latest.is_surely_other and (form is None or probability <= SURELY_OTHER)
    return replace(
        verdict,
        probability=_stated(probability, len(looks)),
        is_surely_other=is_surely_other,
        is_thorough=False,
        is_sure=probability >= AT_ONCE,
    )


def _stated(probability: float, looks: int) -> float:
    """Return how probably a body is a person whose looks, so many, are in the mean of one as probably as this."""
    if probability <= DECISION:
        return probability
    worth = min(1.0 + (looks - 1) / FRESH_LOOKS, SEVERAL_LOOKS)
    return float(scipy.special.expit(worth * scipy.special.logit(probability)))


def telling(verdicts: Sequence[Verdict]) -> list[Verdict]:
    """Return the looks that tell what was seen: those that are evidence, of frames with temperatures."""
    return [one for one in verdicts if one.is_evidence and one.probability is not None]


def _log_ratio_without_skin(looks: Sequence[Verdict]) -> float:
    """Return the log of how likely persons are to show no skin in all looks, over how likely stones are; else 0."""
    if not all(one.is_uniform for one in looks):
        return 0.0
    return math.log(COVERED_SHARE + (1.0 - COVERED_SHARE) * HIDDEN_SHARE ** ((len(looks) - 1) / FRESH_LOOKS))


def _by_warmth(verdict: Verdict) -> float:
    by_warmth = verdict.probability if verdict.by_warmth is None else verdict.by_warmth
    return by_warmth or 0.0


def _with_form(
    log_odds: float, form: Form | None, log_ratio_without_skin: float = 0.0, *, beside_form: float = 1.0
) -> float:
    """Return the probability by temperatures and, where it is known, form: fine pixels tell whether skin shows."""
    if form is None:
        return float(scipy.special.expit(log_odds + log_ratio_without_skin))
    told = form.fineness * min(form.vantage_points / FORM_TOLD, 1.0)
    by_warmth = (1.0 - told * (1.0 - beside_form)) * log_odds
    without_skin = (1.0 - form.fineness) * log_ratio_without_skin
    return float(scipy.special.expit(by_warmth + without_skin + told * log_ratio(form)))


def _log_odds(probability: float) -> float:
    if not 0.0 < probability < 1.0:
        return math.copysign(_SUREST_LOG_ODDS, probability - DECISION)
    log_odds = math.log(probability / (1.0 - probability))
    return max(-_SUREST_LOG_ODDS, min(log_odds, _SUREST_LOG_ODDS))


def _without_temperatures(evidence: Evidence) -> Verdict:
    if evidence.frames == 0:
        return Verdict(FindingKind.ANOMALY, None, ("no temperatures to judge it by",))
    without = "no temperatures, so no probability"
    if evidence.views == 0:
        return Verdict(FindingKind.OBJECT, None, (f"does not stand out in any of {evidence.frames} frames", without))
    stands_out = (
        evidence.vehicles >= MIN_VEHICLES
        and evidence.views >= ENOUGH
        and evidence.contrast_median_k >= MIN_RELATIVE_CONTRAST
        and evidence.concentration >= MIN_CONCENTRATION
    )
    reasons = (
        f"{evidence.contrast_median_k:.1f} times the noise of its surroundings",
        f"{evidence.concentration:.1f} times as frequent as around it",
        _seen_by(evidence),
        without,
    )
    return Verdict(FindingKind.ANOMALY if stands_out else FindingKind.OBJECT, None, reasons)


def _kind(evidence: Evidence, probability: float) -> FindingKind:
    if probability >= DECISION:
        return FindingKind.PERSON
    peak_k = evidence.contrast_peak_k
    is_animal = peak_k - evidence.contrast_median_k >= _FUR_SPREAD_K and peak_k <= MAX_CONTRAST_K
    return FindingKind.ANIMAL if is_animal else FindingKind.WARM_OBJECT


def _reasons(evidence: Evidence) -> tuple[str, ...]:
    peak_k = evidence.contrast_peak_k
    hotter_k = hotter_than_usual_k(evidence)
    if peak_k > MAX_CONTRAST_K and not evidence.in_sun:
        limit = ", hotter than any skin"
    elif hotter_k is None:
        limit = ""
    else:
        limit = f", {hotter_k:.0f} K hotter than clothes" if evidence.in_sun else f", {hotter_k:.0f} K hotter than skin"
    return (
        f"{evidence.contrast_median_k:.0f} K warmer than its surroundings, {peak_k:.0f} K at its warmest{limit}",
        _seen_by(evidence),
        _size(evidence),
    )


def _size(evidence: Evidence) -> str:
    if evidence.form is None:
        return f"{evidence.area_m2:.2f} m² visible, {evidence.extent_m:.1f} m long"
    area_m2, form = evidence.area_m2, evidence.form
    if form.heights_sigma_m2 > _TOLD_HEIGHT_M2:
        return f"{area_m2:.2f} m² visible, {form.length_m:.1f} by {form.width_m:.1f} m seen from above"
    return (
        f"{area_m2:.2f} m² visible, {form.length_m:.1f} by {form.width_m:.1f} m seen from above, "
        f"{form.height_m:.1f} m high"
    )


def _seen_by(evidence: Evidence) -> str:
    frames = _of(evidence.views, evidence.frames, "frame")
    if (evidence.vehicles, evidence.swarm) == (evidence.views, evidence.frames):
        # One frame of each vehicle, or those that a single one has taken along its way, as in a survey.
        return f"seen in {frames}"
    return f"seen by {_of(evidence.vehicles, evidence.swarm, 'vehicle')}, in {frames}"


def _of(count: int, among: int, noun: str) -> str:
    total = f"{count} of {max(count, among)}" if among else str(count)
    return f"{total} {noun}{'' if max(count, among) == 1 else 's'}"
