"""Answers in JSON: NaN as null, and errors as one line for a person."""

import json
import traceback
from collections.abc import Callable
from functools import wraps
from typing import Any

from starlette.requests import Request
from starlette.responses import Response

from labrig._errors import LabrigError
from labrig._fields import check_fields
from labrig._json import EXACT, plain
from labrig.workbench._asked import Asked
from labrig_drivers import DeviceError

__all__ = ["Answer", "answering", "body_of", "failed", "plain", "query_of", "says", "told"]

Answer = Callable[[Request], Any]


def told(content: Any) -> str:
    """Values as JSON text; what is no number becomes null."""
    try:
        return json.dumps(content, default=plain, allow_nan=False, separators=(",", ":"))
    except (TypeError, ValueError):  # a NaN, or a key of numpy's: all is looked through, which takes long
        return json.dumps(plain(content, EXACT), allow_nan=False, separators=(",", ":"))


def says(content: Any, status: int = 200) -> Response:
    """Values as an answer in JSON."""
    return Response(told(content), status, media_type="application/json")


def failed(error: Exception) -> Response:
    """What went wrong, in one line; what nobody expected goes to the terminal in full as well."""
    if isinstance(error, LabrigError):
        return says({"error": str(error)}, 400)
    if isinstance(error, DeviceError):
        return says({"error": str(error)}, 409)
    if isinstance(error, OSError) and error.strerror:
        return says({"error": f"{error.filename or 'a file'}: {error.strerror}"}, 400)
    traceback.print_exception(error)
    line = " ".join(str(error).split())
    return says({"error": f"unexpected {type(error).__name__}: {line}; the terminal says more"}, 500)


def answering(work: Answer) -> Callable[[Request], Response]:
    """An endpoint, run in a thread, of a function that gives plain values or a response and may raise errors."""

    @wraps(work)
    def endpoint(request: Request) -> Response:
        try:
            given = work(request)
        except Exception as error:
            return failed(error)
        return given if isinstance(given, Response) else says(given)

    return endpoint


def body_of(request: Request) -> dict[str, Any]:
    """The JSON object that a request brought (`_guarded` has read it); {} where it brought none.

    Raises `LabrigError` where a field is not of its kind.
    """
    return _checked(request.state.body)


def query_of(request: Request) -> dict[str, Any]:
    """What a request asks for in its address; raises `LabrigError` where a field is not of its kind."""
    return _checked(dict(request.query_params))


def _checked(given: dict[str, Any]) -> dict[str, Any]:
    said = {name: value for name, value in given.items() if value is not None}
    return check_fields(Asked, said, "the request").model_dump(exclude_unset=True, by_alias=True)
