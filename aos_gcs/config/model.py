"""Sections and fields of the configuration file.

The sections ``flight``, ``search``, ``deadlines``, ``detection``, ``uncertainty``, ``tracking``, ``imaging``,
``autofocus``, ``registration``, ``forest``, ``terrain``, ``safety``, ``tak``, ``webhook`` and ``caltopo`` have the
fields and defaults of the settings dataclasses; docs/configuration.md lists them all.
"""

from __future__ import annotations

import ipaddress
import re
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

from aos_gcs.mission.command_order import MAX_AGE_S
from aos_gcs.planning.settings import PreflightSettings
from aos_gcs.wall.model import WallSettings

_STRICT = ConfigDict(extra="forbid", allow_inf_nan=False)

LatLonDeg = tuple[Annotated[float, Field(ge=-90.0, le=90.0)], Annotated[float, Field(ge=-180.0, le=180.0)]]
EastNorthM = tuple[float, float]


class LinkConfig(BaseModel):
    """The connection to the vehicles."""

    model_config = _STRICT

    driver: str = "mavlink"
    urls: Annotated[list[str], Field(min_length=1)]
    """Such as ``udpin://0.0.0.0:14550``."""
    system_id: Annotated[int, Field(ge=1, le=255)] = 254
    """Our own MAVLink system id."""
    options: dict[str, Any] = {}
    """Settings of the driver."""


class MissionConfig(BaseModel):
    """The search area, and the vehicles."""

    model_config = _STRICT

    vehicles: Annotated[int, Field(ge=1, le=250)] | None = None
    """Number of vehicles that fly; by default that of ``vehicle_ids``."""
    vehicle_ids: Annotated[list[Annotated[int, Field(ge=1, le=250)]], Field(min_length=1, max_length=250)] | None = None
    """System ids of the vehicles that fly; others are never armed. Without them an operator chooses."""
    any_vehicles: bool = False
    """Fly with the lowest ids heard, without an operator's choice; for simulations only."""
    area_deg: Annotated[list[LatLonDeg], Field(min_length=3)] | None = None
    """Corners of the search area, latitude and longitude; needs ``origin_deg``. Without any area the mission waits for
    a plan that is drawn in the dashboard."""
    area_enu_m: Annotated[list[EastNorthM], Field(min_length=3)] | None = None
    """Instead of ``area_deg``: metres east and north of the origin."""
    origin_deg: tuple[float, float, float] | None = None
    """Latitude, longitude and altitude AMSL (metres) of the launch site; by default the home of the first vehicle."""
    return_deg: LatLonDeg | None = None
    """Point around which all vehicles land, latitude and longitude; needs ``origin_deg``. By default each lands where
    it started."""
    return_enu_m: EastNorthM | None = None
    """Instead of ``return_deg``: metres east and north of the origin."""
    scan_heading_deg: Annotated[float, Field(ge=0.0, lt=360.0)] = 0.0
    """Direction of the first scan, clockwise from north."""
    camera_fov_deg: Annotated[float, Field(gt=1.0, lt=170.0)] = 50.0
    """Horizontal field of view that legs are planned for."""
    seed: Annotated[int, Field(ge=0)] = 0
    auto_start: bool = False
    auto_return: bool = False


class SwarmConfig(BaseModel):
    """The strategy that chooses positions."""

    model_config = _STRICT

    strategy: str = "aos-apso"
    parameters: dict[str, Any] = {}


def _host(text: str) -> str:
    if not text.strip():
        raise ValueError('give an address such as "127.0.0.1", or "0.0.0.0" to listen in all networks')
    return text


def _host_name(text: str) -> str:
    if not re.fullmatch(r"[\w.-]+", text):
        raise ValueError('give a name without scheme, port and path, such as "station.local"')
    return text


def _folder(path: Path) -> Path:
    if path.exists() and not path.is_dir():
        raise ValueError(f"{path} is a file; name a folder")
    return path


def _network(text: str) -> str:
    ipaddress.ip_network(text)
    return text


class ApiConfig(BaseModel):
    """The dashboard."""

    model_config = _STRICT

    enabled: bool = True
    host: Annotated[str, AfterValidator(_host)] = "127.0.0.1"
    port: Annotated[int, Field(ge=0, le=65535)] = 8080
    open_browser: bool = False
    """Whether the station opens its page in this machine's browser when it starts."""
    operator_code_file: Path | None = None
    """File with the code by which operators sign in; by default a random code that outlasts restarts."""
    accounts: Path | None = None
    """File of accounts, by which everybody signs in instead of operators by the code."""
    anyone_observes: bool = False
    """Whether those who have not signed in may observe where there are accounts."""
    tls: bool = False
    """Encryption with a certificate of the station's own, which is made at the first start."""
    tls_cert: Path | None = None
    """File with the certificate (PEM) by which the dashboard is encrypted."""
    tls_key: Path | None = None
    """File with the certificate's key (PEM); by default the same file."""
    allowed_hosts: tuple[Annotated[str, AfterValidator(_host_name)], ...] = ()
    """Host names, beside ``localhost`` and IP addresses, under which the page may be opened."""
    trusted_proxies: tuple[Annotated[str, AfterValidator(_network)], ...] = ()
    """Addresses and networks of proxies whose headers about clients are believed."""

    @model_validator(mode="after")
    def _key_with_certificate(self) -> Self:
        if self.tls_key is not None and self.tls_cert is None:
            raise ValueError("tls_key needs tls_cert")
        return self

    max_command_age_s: Annotated[float, Field(ge=0.5, le=30.0)] = MAX_AGE_S
    """Oldest state of the mission by which an operator may command, in real seconds: more for slow networks."""
    plans_folder: Annotated[Path, AfterValidator(_folder)] = Path("plans")
    """Folder in which operators save plans."""
    wall_rate_hz: Annotated[float, Field(ge=0.1, le=10.0)] = WallSettings().rate_hz
    """Greatest number of live pictures per tile and second."""
    wall_width_px: Annotated[int, Field(ge=64, le=1280)] = WallSettings().width_px
    """Width of the tiles of live pictures."""
    wall_follow_width_px: Annotated[int, Field(ge=64, le=1920)] = WallSettings().follow_width_px
    """Width of a live picture that fills the screen."""
    basemap: Path | None = None
    """PMTiles file that the dashboard shows below the mission; by default it shows a metric grid only."""


class PreflightConfig(BaseModel):
    """Settings of preflight: what it may change, and which failed checks it overrides."""

    model_config = _STRICT

    upload_fence: bool = False
    """Write the mission's geofence to the vehicles, with the parameters that enforce it."""
    set_return_height: bool = False
    """Set the failsafe return height of each vehicle to its altitude layer, and restore it after landing."""
    overrides: list[str] = []
    """Checks whose failures do not block the launch, on any vehicle, as ``check: reason``."""
    refresh_s: Annotated[float, Field(ge=1.0)] = PreflightSettings().refresh_s
    """Pause before a vehicle whose settings were good is asked for them again."""


class RecordConfig(BaseModel):
    """Recording of missions."""

    model_config = _STRICT

    folder: Annotated[Path, AfterValidator(_folder)] = Path("missions")


class ServiceConfig(BaseModel):
    """The whole file."""

    model_config = _STRICT

    link: LinkConfig
    mission: MissionConfig
    swarm: SwarmConfig = SwarmConfig()
    preflight: PreflightConfig = PreflightConfig()
    flight: dict[str, Any] = {}
    search: dict[str, Any] = {}
    relay: dict[str, Any] = {}
    deadlines: dict[str, Any] = {}
    detection: dict[str, Any] = {}
    uncertainty: dict[str, Any] = {}
    tracking: dict[str, Any] = {}
    imaging: dict[str, Any] = {}
    autofocus: dict[str, Any] = {}
    registration: dict[str, Any] = {}
    forest: dict[str, Any] | None = None
    terrain: dict[str, Any] | None = None
    tak: dict[str, Any] | None = None
    webhook: dict[str, Any] | None = None
    caltopo: dict[str, Any] | None = None
    safety: dict[str, Any] = {}
    api: ApiConfig = ApiConfig()
    record: RecordConfig = RecordConfig()
    clock_speed: Annotated[float, Field(gt=0.0, le=100.0)] = 1.0
    """Clock seconds per real second; above 1 only with vehicles that are simulated at the same speed."""
