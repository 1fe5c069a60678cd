"""The application around a scripted mission."""

from __future__ import annotations

from typing import Any

from fastapi import FastAPI

from aos_gcs.api.app import create_app
from tests.fakes.mission import ScriptedMission


def app_of(mission: ScriptedMission, *args: Any, **options: Any) -> FastAPI:
    """Make the application of a mission that can be commanded."""
    return create_app(mission, *args, commands=mission, **options)
