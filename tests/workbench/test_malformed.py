"""Requests that no page sends: each is refused in one line, and none is an error of the workbench's own."""

import asyncio
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest

from labrig._errors import LabrigError
from labrig.workbench._guarded import MOST_JSON_BYTES, Guarded
from labrig.workbench._seeds import seed_of


@pytest.fixture(scope="module")
def bench(shared_bench: Any) -> Any:
    """The one that the tests of this file share."""
    return shared_bench


@pytest.mark.parametrize(
    ("path", "body", "said"),
    [
        ("watch/now?run=x&since_s=abc", None, "the request: since_s: should be a valid number, not 'abc'"),
        ("watch/now?run=x&since_s=inf", None, "the request: since_s: should be a finite number"),
        ("watch/now?run=x&event=1.5", None, "the request: event: should be a valid integer, not '1.5'"),
        ("tag", {"run": "x", "tags": 5}, "the request: tags: should be a list, not 5"),
        ("tag", {"run": "x", "tags": "abc"}, "the request: tags: should be a list, not 'abc'"),
        ("note", {"run": {}, "text": "x"}, "the request: run: should be a valid string, not fields"),
        ("columns", {"mapping": "a: 1", "chosen": 5}, "the request: chosen: should be a list, not 5"),
        ("columns", {"mapping": "a: 1", "chosen": [{}]}, "the request: chosen: entry 1: column: is missing"),
        ("columns", {"mapping": "a: 1", "header": 5}, "the request: header: should be a list, not 5"),
        ("columns", {"mapping": "a: 2001-13-45"}, "the mapping: a value in it cannot be read"),
        ("columns", {"mapping": "[" * 3000}, "the mapping: a value in it cannot be read"),
        ("watch/plan", {"arguments": 5}, "the request: arguments: should be a list, not 5"),
        ("which", {"run": "x", "with": 5}, "the request: with: should be a list, not 5"),
        ("next", {"run": "x", "minutes": [1]}, "the request: minutes: should be a valid string, not a list"),
        ("setup/check", {"form": 5}, "the request: form: should hold fields (name: value), not 5"),
    ],
)
def test_a_field_of_another_kind_is_refused(ask: Any, capsys: Any, path: str, body: Any, said: str) -> None:
    """The answer names the field and what it should be, in one line, and the terminal stays quiet."""
    status, answer = ask(f"/api/{path}", body)
    assert (status, answer["error"][: len(said)]) == (400, said)
    assert "\n" not in answer["error"]
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    "text", [b"[" * 200_000, b'{"a":' * 300 + b"1", b'{"a": NaN}', b'{"a": "\\ud800"}', b"5"]
)
def test_what_is_no_json_of_a_page_is_refused(ask: Any, text: bytes) -> None:
    """Also what is nested without end, and letters that no file can hold."""
    status, said = ask("/api/note", text, content_type="application/json")
    assert (status, said) == (400, "the request brings no JSON object")


def test_what_comes_in_pieces_has_the_same_limit() -> None:
    """A request that does not say how long it is is read no further than the limit."""
    read, sent = 0, []

    async def receive() -> Any:
        nonlocal read
        read += 1
        return {"type": "http.request", "body": b"x" * 1_000_000, "more_body": read < 9}

    async def send(message: Any) -> None:
        sent.append(message)

    async def never(*_: Any) -> None:
        raise AssertionError("it was handed on")

    headers = [(b"host", b"127.0.0.1"), (b"x-labrig-token", b"t"), (b"content-type", b"application/json")]
    scope = {"type": "http", "method": "POST", "path": "/api/note", "query_string": b"", "headers": headers}
    asked = Guarded(never, "t")({**scope, "scheme": "http"}, receive, send)
    with ThreadPoolExecutor(1) as own:  # a browser that other tests share has a loop in this thread
        own.submit(asyncio.run, asked).result()
    assert sent[0]["status"] == 413
    assert read == MOST_JSON_BYTES // 1_000_000 + 1


def test_a_seed_of_many_digits_is_refused() -> None:
    """However long it is, it is said in a line that can be read."""
    with pytest.raises(LabrigError, match=r"seed 9{16}: give a whole number") as said:
        seed_of({"seed": "9" * 5000})
    assert len(str(said.value)) < 100
