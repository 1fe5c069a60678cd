"""Strategies as a user names them: ``aos-pso``, ``aos-apso(gamma=0.8, min_factor=0.25)``."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from aos_gcs.errors import ConfigurationError
from aos_gcs.swarm.model import Strategy
from aos_gcs.swarm.registry import make_strategy

_ENTRY = re.compile(r"\s*(?P<name>[A-Za-z0-9_.-]+)\s*(?:\((?P<parameters>[^()]*)\))?\s*")
_WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_-]*")


@dataclass(frozen=True, slots=True)
class StrategyChoice:
    """A strategy of the registry with the parameters that differ from its defaults."""

    name: str
    parameters: Mapping[str, object] = field(default_factory=dict)

    @property
    def label(self) -> str:
        """The text that names it, always the same for the same choice."""
        if not self.parameters:
            return self.name
        inside = ", ".join(f"{name}={_written(value)}" for name, value in sorted(self.parameters.items()))
        return f"{self.name}({inside})"

    def make(self) -> Strategy[Any]:
        """Return the strategy; see :func:`aos_gcs.swarm.registry.make_strategy`."""
        return make_strategy(self.name, self.parameters)


def parse_strategies(text: str) -> tuple[StrategyChoice, ...]:
    """Return the strategies of a list with commas; parameters stand in parentheses.

    Values are numbers, ``true``, ``false``, ``null`` or plain words.

    Raises:
        ConfigurationError: the text cannot be understood, a strategy is named twice, is unknown, or refuses a
            parameter.
    """
    choices = []
    position = 0
    while True:
        entry = _ENTRY.match(text, position)
        if entry is None or text[entry.end() : entry.end() + 1] not in ("", ","):
            raise ConfigurationError(
                f"strategies cannot be read from {text[position:].strip()!r} on; write names with commas between, and "
                "parameters in parentheses, as in aos-pso,aos-apso(gamma=0.8)."
            )
        choices.append(StrategyChoice(entry["name"], _parse_parameters(entry["parameters"] or "", entry["name"])))
        if entry.end() == len(text):
            break
        position = entry.end() + 1
    labels = [choice.label for choice in choices]
    for label in labels:
        if labels.count(label) > 1:
            raise ConfigurationError(f"strategies names {label} twice; each can run only once.")
    for choice in choices:
        choice.make()
    return tuple(choices)


def _parse_parameters(text: str, strategy: str) -> dict[str, object]:
    parameters: dict[str, object] = {}
    for assignment in filter(str.strip, text.split(",")):
        name, equals, value = (part.strip() for part in assignment.partition("="))
        if not equals or not _WORD.fullmatch(name):
            raise ConfigurationError(f"{assignment.strip()!r} of {strategy} must be name=value, as in gamma=0.8.")
        if name in parameters:
            raise ConfigurationError(f"{name} of {strategy} is given twice.")
        parameters[name] = _parse_value(value, name, strategy)
    return parameters


def _parse_value(text: str, name: str, strategy: str) -> object:
    try:
        value: object = json.loads(text)
    except ValueError:
        if _WORD.fullmatch(text):
            return text
        raise ConfigurationError(
            f"{name} of {strategy} must be a number, true, false or a word, but is {text!r}."
        ) from None
    return value


def _written(value: object) -> str:
    return value if isinstance(value, str) else json.dumps(value)
