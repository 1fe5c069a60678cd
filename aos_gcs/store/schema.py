"""The tables of ``mission.sqlite`` and the names in a mission folder. docs/mission-folder.md describes both."""

from __future__ import annotations

from typing import Final

DATABASE_NAME: Final = "mission.sqlite"
MANIFEST_NAME: Final = "manifest.json"
FRAMES_NAME: Final = "frames"
PICTURES_NAME: Final = "pictures"
GROUND_NAME: Final = "ground"
MAVLINK_NAME: Final = "mavlink"

SCHEMA_VERSION: Final = 4


def picture_path(step: int, kind: str) -> str:
    """Return where in the mission's folder a step's raster of a kind lies."""
    return f"{PICTURES_NAME}/{step:05d}_{kind}.png"


TABLES: Final = """
CREATE TABLE events (
    seq INTEGER PRIMARY KEY,
    utc_s REAL NOT NULL,
    kind TEXT NOT NULL,
    data TEXT NOT NULL
);
CREATE TABLE steps (
    step INTEGER PRIMARY KEY,
    record TEXT NOT NULL,
    strategy_state TEXT NOT NULL
);
CREATE TABLE searches (
    id INTEGER PRIMARY KEY,
    record TEXT NOT NULL
);
CREATE TABLE decisions (
    step INTEGER PRIMARY KEY,
    record TEXT NOT NULL,
    conclusion TEXT
);
CREATE TABLE frames (
    id INTEGER PRIMARY KEY,
    step INTEGER NOT NULL,
    vehicle_id INTEGER NOT NULL,
    image_index INTEGER NOT NULL,
    utc_s REAL NOT NULL,
    time_sigma_s REAL,
    latitude_deg REAL NOT NULL,
    longitude_deg REAL NOT NULL,
    altitude_amsl_m REAL NOT NULL,
    q_cam2enu_wxyz TEXT NOT NULL,
    R_cam2enu TEXT NOT NULL,
    camera TEXT NOT NULL,
    bands TEXT NOT NULL,
    dtype TEXT NOT NULL,
    path TEXT NOT NULL,
    digest TEXT NOT NULL
);
CREATE INDEX frames_of_step ON frames (step, vehicle_id);
CREATE TABLE actions (
    id INTEGER PRIMARY KEY,
    utc_s REAL NOT NULL,
    record TEXT NOT NULL
);
CREATE TRIGGER actions_are_not_changed BEFORE UPDATE ON actions
BEGIN SELECT RAISE(ABORT, 'the audit log is append-only'); END;
CREATE TRIGGER actions_are_not_deleted BEFORE DELETE ON actions
BEGIN SELECT RAISE(ABORT, 'the audit log is append-only'); END;
CREATE TABLE audit (
    entry INTEGER PRIMARY KEY,
    source TEXT NOT NULL,
    source_row INTEGER NOT NULL,
    digest TEXT NOT NULL
);
CREATE INDEX audit_of_source ON audit (source, source_row);
CREATE TRIGGER audit_is_not_changed BEFORE UPDATE ON audit
BEGIN SELECT RAISE(ABORT, 'the audit log is append-only'); END;
CREATE TRIGGER audit_is_not_deleted BEFORE DELETE ON audit
BEGIN SELECT RAISE(ABORT, 'the audit log is append-only'); END;
CREATE TABLE settings (
    id INTEGER PRIMARY KEY,
    utc_s REAL NOT NULL,
    record TEXT NOT NULL
);
CREATE TABLE outcome (
    id INTEGER PRIMARY KEY CHECK (id = 1),
    utc_s REAL NOT NULL,
    outcome TEXT NOT NULL,
    summary TEXT NOT NULL
);
"""
