"""The OpenAPI document, with the WebSocket's messages among its schemas.

``python -m aos_gcs.api.openapi`` prints it; the dashboard's TypeScript types are generated from that.
"""

from __future__ import annotations

import json
import sys
from functools import cache
from importlib.metadata import version
from typing import Any

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi

from aos_gcs.api.models.messages import SERVER_MESSAGE
from aos_gcs.api.models.wall import WALL_CLIENT_MESSAGE, WALL_MESSAGE
from aos_gcs.api.routers import (
    accounts,
    basemap,
    control,
    events,
    findings,
    ground,
    handover,
    kml,
    mission,
    operation,
    plans,
    proposals,
    relief,
    replay,
    session,
    video,
    viewer,
    wall,
)

_DESCRIPTION = (
    "Ground control of a swarm of camera drones. Errors have the body ErrorModel. The WebSocket /api/events sends "
    "ServerMessage objects as JSON text: hello first, then the mission's events. The WebSocket /api/wall sends a "
    "WallMessage and the JPEG files that it names, as one binary message: the length of the head in four bytes, head, "
    "files; clients send WallClientMessage objects."
)


def add_routes(app: FastAPI) -> None:
    """Add all routes of the API."""
    of_findings = (kml, findings, handover)  # The file with pictures before those without.
    for group in (
        session,
        accounts,
        control,
        mission,
        operation,
        plans,
        proposals,
        replay,
        viewer,
        *of_findings,
        ground,
        basemap,
        relief,
        events,
        wall,
        video,
    ):
        # Routers state whole paths. Other than with include_router, applications share the routes once they are built.
        app.router.routes.extend(group.router.routes)


@cache
def make_document() -> dict[str, Any]:
    """Return the document; no mission is needed for it."""
    app = FastAPI()
    add_routes(app)
    document = get_openapi(title="aos-gcs", version=version("aos-gcs"), description=_DESCRIPTION, routes=app.routes)
    schema = SERVER_MESSAGE.json_schema(mode="serialization", ref_template="#/components/schemas/{model}")
    document["components"]["schemas"] |= schema.pop("$defs")
    document["components"]["schemas"]["ServerMessage"] = schema
    for name, model in (("WallMessage", WALL_MESSAGE), ("WallClientMessage", WALL_CLIENT_MESSAGE)):
        schema = model.json_schema(mode="serialization", ref_template="#/components/schemas/{model}")
        document["components"]["schemas"] |= schema.pop("$defs")
        document["components"]["schemas"][name] = schema
    return document


if __name__ == "__main__":
    json.dump(make_document(), sys.stdout, indent=2)
    sys.stdout.write("\n")
