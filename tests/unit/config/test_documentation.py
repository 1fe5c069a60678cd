"""docs/configuration.md against the code: every field is there, and its default is the real one."""

import ast
import dataclasses
import math
import re
import tomllib
from pathlib import Path

import pytest

from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.config.file import parse_config
from aos_gcs.config.model import (
    ApiConfig,
    LinkConfig,
    MissionConfig,
    PreflightConfig,
    RecordConfig,
    ServiceConfig,
    SwarmConfig,
)
from aos_gcs.imaging.geolocation import Uncertainty
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.planning.search_settings import SearchSettings
from aos_gcs.planning.settings import (
    AutofocusSettings,
    Deadlines,
    DetectionSettings,
    FlightSettings,
    ForestSettings,
    RegistrationSettings,
    RelaySettings,
)
from aos_gcs.sharing.settings import CaltopoSettings, TakSettings, WebhookSettings
from aos_gcs.tracking.motion import MotionSettings
from aos_gcs.tracking.tracker import TrackingSettings

TEXT = (Path(__file__).resolve().parents[3] / "docs" / "configuration.md").read_text(encoding="utf-8")
SECTIONS = {
    "link": LinkConfig,
    "mission": MissionConfig,
    "swarm": SwarmConfig,
    "preflight": PreflightConfig,
    "flight": FlightSettings,
    "search": SearchSettings,
    "relay": RelaySettings,
    "detection": DetectionSettings,
    "uncertainty": Uncertainty,
    "tracking": TrackingSettings,
    "imaging": ImagingSettings,
    "autofocus": AutofocusSettings,
    "registration": RegistrationSettings,
    "forest": ForestSettings,
    "tak": TakSettings,
    "webhook": WebhookSettings,
    "caltopo": CaltopoSettings,
    "safety": SafetyLimits,
    "deadlines": Deadlines,
    "api": ApiConfig,
    "record": RecordConfig,
}


def defaults_of(settings: type) -> dict[str, object]:
    """Field to default, ``...`` where there is none; angles in degrees, as the file has them."""
    if dataclasses.is_dataclass(settings):
        found = {entry.name: entry.default for entry in dataclasses.fields(settings)}
        found = {name: ... if default is dataclasses.MISSING else default for name, default in found.items()}
    else:
        fields = settings.model_fields  # type: ignore[attr-defined]
        found = {name: ... if entry.is_required() else entry.default for name, entry in fields.items()}
    return {
        re.sub("_rad$", "_deg", name): math.degrees(value) if name.endswith("_rad") else value
        for name, value in found.items()
    }


def section(name: str) -> str:
    (heading,) = re.findall(rf"^## .*`\[{name}\]`.*$", TEXT, re.MULTILINE)
    return TEXT.partition(heading)[2].partition("\n## ")[0]


def stated_defaults(text: str) -> dict[str, str]:
    """Field to the default that a table or a parenthesis states."""
    stated = {name.rpartition(".")[2]: value for name, value in re.findall(r"`([\w.]+)` \(([^();:,]+)[);:,]", text)}
    for fields, values in re.findall(r"^\| ([^|]*`\w+`[^|]*) \| ([^|]+) \|", text, re.MULTILINE):
        names = re.findall(r"`(\w+)`", fields)
        each = values.split(", ") if " or " not in fields and len(values.split(", ")) == len(names) else [values]
        stated |= dict(zip(names, each * (len(names) if len(each) == 1 else 1), strict=False))
    return stated


@pytest.mark.parametrize("name", SECTIONS)
def test_every_field_is_documented_with_its_default(name: str) -> None:
    text, defaults = section(name), defaults_of(SECTIONS[name])
    missing = {field for field in defaults if not re.search(rf"`({name}\.)?{field}`", text)} - {"motion"}
    assert missing == set()
    wrong = {}
    for field, stated in stated_defaults(text).items():
        try:
            value = ast.literal_eval({"true": "True", "false": "False"}.get(stated.strip("`"), stated.strip("`")))
        except (SyntaxError, ValueError):
            continue  # described in words
        if field in defaults and str(defaults[field]) != str(value) and defaults[field] != pytest.approx(value):
            wrong[field] = (stated, defaults[field])
    assert wrong == {}


def test_every_section_is_documented() -> None:
    assert {name for name in ServiceConfig.model_fields if f"`[{name}]`" not in TEXT} == {"clock_speed"}


def test_the_motion_of_targets_is_documented() -> None:
    stated = stated_defaults(section("tracking"))
    for field, default in defaults_of(MotionSettings).items():
        assert ast.literal_eval(stated[field]) == pytest.approx(default)


def test_the_example_is_accepted() -> None:
    (example,) = re.findall(r"```toml\n(.*?)```", TEXT, re.DOTALL)
    parse_config(tomllib.loads(example))
