"""Kinds of bodies by their form: the likelihood of a person over that of an animal, a stone or a stump.

Each kind of body has a typical length, width and height, and a typical pattern of warmth: a person's skin is a small
part of it, some kelvin warmer than the clothes, while an animal's head and legs are a quarter of it and a stone is
equally warm all over. None of this depends on how warm bodies are altogether, which changes with the day. The figures
are those of bodies in simulated missions (docs/effectiveness.md); the widths of their distributions are larger than
seen there, since real bodies vary more.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from aos_gcs.imaging.persons.form import Form

MAX_LOG_RATIO = 6.0
"""Logarithm of the likelihood ratio above which, on either side, a form says no more."""
_LENGTH_NOISE = 0.5
"""Standard deviation of the logarithm of the length that one vantage point tells; n tell it better by the root of n."""
_SLENDERNESS_NOISE = 1.0
"""The same for the ratio of width and length."""


@dataclass(frozen=True, slots=True)
class _Normal:
    """A normal distribution; of a positive quantity, that of its logarithm about the logarithm of the middle."""

    middle: float
    sigma: float

    def density(self, value: float, noise: float = 0.0) -> float:
        sigma = math.hypot(self.sigma, noise)
        return math.exp(-0.5 * ((value - self.middle) / sigma) ** 2) / sigma

    def log_density(self, value: float, noise: float = 0.0) -> float:
        sigma = math.hypot(self.sigma, noise)
        return math.exp(-0.5 * (math.log(value / self.middle) / sigma) ** 2) / sigma


@dataclass(frozen=True, slots=True)
class _Pattern:
    """Pattern of warmth of some bodies of a kind."""

    share: float
    spread_k: _Normal
    hot_share: _Normal

    def density(self, spread_k: float, hot_share: float) -> float:
        """Return the density of such a pattern, times the share."""
        return self.share * self.spread_k.log_density(spread_k) * self.hot_share.log_density(hot_share)


@dataclass(frozen=True, slots=True)
class _Warmth:
    """Patterns of warmth of a kind of bodies."""

    usual: tuple[_Pattern, ...]
    out_of_focus: _Pattern
    """Pattern in images of optics out of focus, where the middle of what leaves leave is cooler than the body is."""
    in_sun: _Pattern
    """Pattern where spots of sun lie on them."""

    def density(self, form: Form) -> float:
        """Return the density of a form's pattern of warmth."""
        spread_k, hot_share = max(form.spread_k, _LEAST_SPREAD_K), max(form.hot_share, _LEAST_SHARE)
        usual = sum(pattern.density(spread_k, hot_share) for pattern in self.usual)
        in_sun = form.in_sun * self.in_sun.share
        in_focus = (1.0 - in_sun) * usual + form.in_sun * self.in_sun.density(spread_k, hot_share)
        out_of_focus = self.out_of_focus.density(spread_k, hot_share)
        return (1.0 - form.out_of_focus) * in_focus + form.out_of_focus * out_of_focus


@dataclass(frozen=True, slots=True)
class _Kind:
    """Bodies that are alike."""

    share: float
    """Share among persons, or among others."""
    length_m: _Normal
    slenderness: _Normal
    """Width over length."""
    heights_m2: _Normal
    """Variance of the heights of what is seen."""
    warmth: _Warmth

    def likelihood(self, form: Form) -> float:
        """Return the density of a form among bodies of this kind, times their share."""
        noise = 1.0 / math.sqrt(form.vantage_points)
        return (
            self.share
            * self.warmth.density(form)
            * self.length_m.log_density(form.length_m, _LENGTH_NOISE * noise)
            * self.slenderness.log_density(form.width_m / form.length_m, _SLENDERNESS_NOISE * noise)
            * self.heights_m2.density(max(form.heights_m2, _LEAST_HEIGHTS_M2), form.heights_sigma_m2)
        )


_LEAST_SPREAD_K = 0.3
_LEAST_SHARE = 0.01
_LEAST_HEIGHTS_M2 = -0.05
"""Estimated variance of heights below which it says no more: no variance is negative, and leaves, which hide more of
what is seen from the side, lower the estimate for all kinds alike."""
_EVEN = _Normal(0.15, 0.8)
"""Share of hot pixels of what is equally warm all over: it means nothing there."""
_IN_SUN = _Pattern(0.7, _Normal(11.0, 0.5), _Normal(0.12, 1.0))
"""Spots of sun on clothes or fur, on most bodies of a sunny day: how much warmer they are depends on sun, wind and
colour, so that the pattern tells no person from an animal."""
_CLAD = _Warmth(
    usual=(
        _Pattern(0.78, _Normal(6.5, 0.4), _Normal(0.07, 0.7)),
        _Pattern(0.10, _Normal(10.0, 0.4), _Normal(0.28, 0.5)),
        _Pattern(0.12, _Normal(0.8, 0.3), _EVEN),
    ),
    out_of_focus=_Pattern(1.0, _Normal(5.2, 0.35), _Normal(0.137, 0.5)),
    in_sun=_IN_SUN,
)
"""Clothes with some skin; a blanket with some skin and clothes; no skin to be seen."""
_FUR = _Warmth(
    usual=(_Pattern(1.0, _Normal(4.7, 0.3), _Normal(0.22, 0.5)),),
    out_of_focus=_Pattern(1.0, _Normal(4.1, 0.35), _Normal(0.10, 0.5)),
    in_sun=_IN_SUN,
)
_SOLID = _Warmth(
    usual=(_Pattern(0.98, _Normal(1.4, 0.3), _EVEN), _Pattern(0.02, _Normal(4.0, 0.5), _EVEN)),
    out_of_focus=_Pattern(1.0, _Normal(3.4, 0.5), _Normal(0.16, 0.5)),
    in_sun=_Pattern(0.3, _Normal(5.0, 0.6), _Normal(0.15, 0.8)),
)
"""Top and sides of a stone; a few are sharpened wrongly, or have something warmer on them."""
_ANY_PATTERN = _Pattern(1.0, _Normal(3.0, 0.8), _Normal(0.2, 0.8))
_ANY_WARMTH = _Warmth((_ANY_PATTERN,), out_of_focus=_ANY_PATTERN, in_sun=_ANY_PATTERN)
_ANYTHING = _Kind(0.05, _Normal(0.8, 0.6), _Normal(0.5, 0.6), _Normal(0.06, 0.08), _ANY_WARMTH)
"""What nobody has thought of."""


def _two(warmth: _Warmth) -> _Kind:
    """Return two bodies side by side, 0.8 to 2.5 m apart, which nothing tells apart: they are seen as one."""
    return _Kind(0.05, _Normal(2.4, 0.35), _Normal(0.28, 0.45), _Normal(0.05, 0.09), warmth)


_PERSONS = (
    _Kind(0.53, _Normal(0.59, 0.12), _Normal(0.66, 0.27), _Normal(0.149, 0.035), _CLAD),
    _Kind(0.25, _Normal(0.69, 0.12), _Normal(0.69, 0.18), _Normal(0.034, 0.035), _CLAD),
    _Kind(0.20, _Normal(1.40, 0.09), _Normal(0.39, 0.14), _Normal(-0.01, 0.05), _CLAD),
    _two(_CLAD),
)
"""Standing or walking, sitting, lying, two; a body on the ground is seen a little stretched the other way."""
_OTHERS = (
    _Kind(0.45, _Normal(1.13, 0.17), _Normal(0.35, 0.27), _Normal(0.045, 0.045), _FUR),
    _Kind(0.25, _Normal(0.83, 0.32), _Normal(0.77, 0.17), _Normal(0.037, 0.035), _SOLID),
    _Kind(0.25, _Normal(0.50, 0.22), _Normal(0.84, 0.18), _Normal(0.063, 0.03), _SOLID),
    _two(_FUR),
    _two(_SOLID),
    _ANYTHING,
)
"""Animals, stones, stumps, two animals, two stones or a trunk."""
_UNUSUAL_PERSONS = 0.02
"""Share of persons of whom nobody has thought."""


def log_ratio(form: Form) -> float:
    """Return the logarithm of how likely the form is among persons, over how likely among others."""
    persons = sum(kind.likelihood(form) for kind in _PERSONS)
    persons += _UNUSUAL_PERSONS / _ANYTHING.share * _ANYTHING.likelihood(form)
    others = sum(kind.likelihood(form) for kind in _OTHERS)
    return max(-MAX_LOG_RATIO, min(math.log(persons / others), MAX_LOG_RATIO))
