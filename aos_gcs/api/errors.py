"""Conversion of errors into answers."""

from __future__ import annotations

from http import HTTPStatus

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from starlette.exceptions import HTTPException

from aos_gcs.api.access.accounts import AccountError, InvitationError
from aos_gcs.api.access.control import NotInControlError
from aos_gcs.api.access.operators import (
    AccessDeniedError,
    RoleError,
    SignInRequiredError,
    TooManyGuessesError,
    WrongCodeError,
)
from aos_gcs.api.access.plan_check_turns import TooManyChecksError
from aos_gcs.api.models.base import ErrorModel
from aos_gcs.errors import AosError, CommandError, ConfigurationError, InputDataError, LinkError, MissionError
from aos_gcs.input_values import problem_texts
from aos_gcs.mission.command_order import OutdatedError
from aos_gcs.mission.viewing import ViewerBusyError
from aos_gcs.store.plan_folder import PlanChangedError


class NotFoundError(AosError):
    """A resource that does not exist, or not yet."""


class SeenMissingError(AosError):
    """A command that does not name the state by which it was given."""


class TooLargeError(AosError):
    """A request body that is too large."""


_STATUS_AND_ID: dict[type[AosError], tuple[int, str]] = {
    NotFoundError: (HTTPStatus.NOT_FOUND, "not_found"),
    TooManyGuessesError: (HTTPStatus.TOO_MANY_REQUESTS, "too_many_guesses"),
    WrongCodeError: (HTTPStatus.FORBIDDEN, "wrong_code"),
    InvitationError: (HTTPStatus.FORBIDDEN, "invitation_unusable"),
    SignInRequiredError: (HTTPStatus.UNAUTHORIZED, "sign_in_required"),
    RoleError: (HTTPStatus.FORBIDDEN, "role_required"),
    AccessDeniedError: (HTTPStatus.FORBIDDEN, "operators_only"),
    AccountError: (HTTPStatus.CONFLICT, "account_unchanged"),
    TooLargeError: (HTTPStatus.REQUEST_ENTITY_TOO_LARGE, "too_large"),
    InputDataError: (HTTPStatus.UNPROCESSABLE_ENTITY, "unusable_data"),
    ConfigurationError: (HTTPStatus.UNPROCESSABLE_ENTITY, "unusable_setting"),
    SeenMissingError: (HTTPStatus.PRECONDITION_REQUIRED, "seen_required"),
    OutdatedError: (HTTPStatus.CONFLICT, "out_of_date"),
    MissionError: (HTTPStatus.CONFLICT, "action_not_allowed"),
    NotInControlError: (HTTPStatus.CONFLICT, "not_in_control"),
    TooManyChecksError: (HTTPStatus.TOO_MANY_REQUESTS, "too_many_checks"),
    PlanChangedError: (HTTPStatus.CONFLICT, "plan_changed"),
    ViewerBusyError: (HTTPStatus.SERVICE_UNAVAILABLE, "busy"),
    LinkError: (HTTPStatus.BAD_GATEWAY, "link_failed"),
    CommandError: (HTTPStatus.BAD_GATEWAY, "command_failed"),
    AosError: (HTTPStatus.INTERNAL_SERVER_ERROR, "service_failed"),
}


def error_response(status: int, error_id: str, message: str) -> JSONResponse:
    """Make an answer with the body that all errors have."""
    return JSONResponse(ErrorModel(id=error_id, message=message).model_dump(), status_code=status)


def status_and_id(error: AosError) -> tuple[int, str]:
    """Return the HTTP status and the stable id for an error, by its nearest class in the table."""
    return next(_STATUS_AND_ID[kind] for kind in type(error).__mro__ if kind in _STATUS_AND_ID)


def _describe(error: RequestValidationError) -> str:
    # The place of an error in JSON that cannot be read is an offset, and none of a field.
    fields = [item | {"loc": () if item["type"] == "json_invalid" else item["loc"][1:]} for item in error.errors()]
    return f"Invalid request: {'; '.join(problem_texts(fields, 'the body'))}."


def add_error_handlers(app: FastAPI) -> None:
    """Give every error of ``app`` the body :class:`ErrorModel`."""

    @app.exception_handler(AosError)
    async def on_aos_error(_: Request, error: AosError) -> JSONResponse:
        response = error_response(*status_and_id(error), str(error))
        if isinstance(error, TooManyGuessesError):
            response.headers["Retry-After"] = str(error.retry_after_s)
        return response

    @app.exception_handler(RequestValidationError)
    async def on_invalid_request(_: Request, error: RequestValidationError) -> JSONResponse:
        return error_response(HTTPStatus.UNPROCESSABLE_ENTITY, "invalid_request", _describe(error))

    @app.exception_handler(HTTPException)
    async def on_http_error(request: Request, error: HTTPException) -> JSONResponse:
        error_id = HTTPStatus(error.status_code).phrase.lower().replace(" ", "_")
        message = f"{request.method} {request.url.path}: {error.detail}."
        response = error_response(error.status_code, error_id, message)
        response.headers.update(error.headers or {})
        return response
