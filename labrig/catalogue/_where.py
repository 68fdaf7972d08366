"""Conditions on runs, such as `verdict == 'identified' and captures > 20`.

The text is parsed as a Python expression and never run: what is not a comparison of columns and values is refused.
"""

import ast
import operator
import re
import warnings
from collections.abc import Callable
from functools import reduce
from itertools import pairwise
from typing import Any, NamedTuple, NoReturn

from labrig._errors import LabrigError
from labrig._near import meant
from labrig._paths import wrong
from labrig.catalogue._row import COLUMNS, Row

Value = Callable[[Row], Any]
_EXAMPLE = "verdict == 'identified' and captures > 20"
_ORDER: dict[type[ast.cmpop], Callable[[Any, Any], bool]] = {
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}
_ARITHMETIC: dict[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}
_WORDS = {
    "text": "a text",
    "number": "a number",
    "texts": "a list of words",
    "choice": "a list",
    "truth": "a condition",
    "nothing": "None",
}


_MOMENT = "started"
_WRITTEN = re.compile(r"\d{4}(-\d\d(-\d\d( \d\d(:\d\d(:\d\d)?)?)?)?)?")


class _Part(NamedTuple):
    """A part of a condition: what it is (a key of `_WORDS`), what it is of a row, and how it was written.

    `text` is the text itself, where it is one that stands there.
    """

    kind: str
    of: Value
    said: str
    text: str | None = None


class _WrongError(Exception):
    """What is wrong with a condition, in words."""


def condition(text: str) -> Callable[[Row], bool]:
    """Whether a row fits; raises `LabrigError` for a text that is no condition, or names a column that there is not."""
    if not isinstance(text, str):
        raise wrong("a condition", text, f"a text such as {_EXAMPLE!r}")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            tree = ast.parse(text.strip(), mode="eval")
        part = _truth(tree.body)
    except _WrongError as said:
        raise LabrigError(f"where {text!r}: {said}") from None
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise LabrigError(
            f"where {text!r}: can't be read; write it like {_EXAMPLE} (== compares, texts stand in quotes)"
        ) from None
    return part.of


def _truth(node: ast.expr) -> _Part:
    part = _part(node)
    if part.kind != "truth":
        raise _WrongError(f"{part.said} is {_WORDS[part.kind]}, no condition; write it like {_EXAMPLE}")
    return part


def _part(node: ast.expr) -> _Part:
    said = ast.unparse(node)
    match node:
        case ast.BoolOp(op=op, values=values):
            parts = [_truth(value).of for value in values]
            every = all if isinstance(op, ast.And) else any
            return _Part("truth", lambda row: every(part(row) for part in parts), said)
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            inner = _truth(operand).of
            return _Part("truth", lambda row: not inner(row), said)
        case ast.Compare():
            return _comparison(node, said)
        case ast.Name(id=name):
            return _column(name)
        case ast.Constant(value=None):
            return _Part("nothing", lambda row: None, said)
        case ast.Constant(value=bool(value)):
            return _Part("truth", lambda row: value, said)
        case ast.Constant(value=(str() | int() | float()) as value):
            text = value if isinstance(value, str) else None
            return _Part("number" if text is None else "text", lambda row: value, said, text)
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return _number(operator.sub, [ast.Constant(0), operand], said)
        case ast.BinOp(op=op, left=left, right=right) if type(op) in _ARITHMETIC:
            return _number(_ARITHMETIC[type(op)], [left, right], said)
        case ast.List(elts=elements) | ast.Tuple(elts=elements) | ast.Set(elts=elements):
            values = [_value(element) for element in elements]
            if not all(isinstance(value, str | int | float) for value in values):
                raise _WrongError(f"{said}: a list holds texts and numbers only")
            return _Part("choice", lambda row: values, said)
    raise _WrongError(f"{said}: a condition only compares columns with values, like {_EXAMPLE}")


def _value(node: ast.expr) -> Any:
    """What an entry of a list is; None where that is no text and no number."""
    match node:
        case ast.Constant(value=(str() | int() | float()) as value):
            return value
        case ast.UnaryOp(op=ast.USub(), operand=ast.Constant(value=(int() | float()) as value)):
            return -value
    return None


def _column(name: str) -> _Part:
    if name not in COLUMNS:
        raise _WrongError(
            f"there is no column {name!r}{meant(name, COLUMNS)} (columns: {', '.join(COLUMNS)})"
        )
    return _Part(COLUMNS[name], operator.attrgetter(name), name)


def _number(compute: Callable[[Any, Any], float], nodes: list[ast.expr], said: str) -> _Part:
    parts = [_part(node) for node in nodes]
    for part in parts:
        if part.kind != "number":
            raise _WrongError(f"{said}: {part.said} is {_WORDS[part.kind]}, no number")

    def value(row: Row) -> float | None:
        try:
            return reduce(compute, (part.of(row) for part in parts))
        except (TypeError, ArithmeticError):  # of what is not known nothing is known
            return None

    return _Part("number", value, said)


def _comparison(node: ast.Compare, said: str) -> _Part:
    """Every pair of neighbours, as in `1 < error < 3`."""
    parts = [_part(each) for each in (node.left, *node.comparators)]
    tests = [_test(a, op, b) for (a, b), op in zip(pairwise(parts), node.ops, strict=True)]
    return _Part("truth", lambda row: all(test(row) for test in tests), said)


def _test(a: _Part, op: ast.cmpop, b: _Part) -> Callable[[Row], bool]:
    if isinstance(op, ast.In | ast.NotIn):
        inside = _inside(a, b)
        return inside if isinstance(op, ast.In) else lambda row: not inside(row)
    if isinstance(op, ast.Eq | ast.NotEq | ast.Is | ast.IsNot) and "nothing" in (a.kind, b.kind):
        some = b.of if a.kind == "nothing" else a.of
        present = isinstance(op, ast.NotEq | ast.IsNot)
        return lambda row: (some(row) not in (None, "", ())) is present
    if a.kind == b.kind == "text":
        a, b = _moments(a, b), _moments(b, a)
    if a.kind != b.kind or a.kind not in ("text", "number") or isinstance(op, ast.Is | ast.IsNot):
        _cannot(a, b)
    if type(op) in _ORDER:
        compare = _ORDER[type(op)]
        return lambda row: _known(x := a.of(row)) and _known(y := b.of(row)) and compare(x, y)
    if isinstance(op, ast.Eq):
        return lambda row: a.of(row) == b.of(row)
    return lambda row: a.of(row) != b.of(row)


def _moments(a: _Part, b: _Part) -> _Part:
    """A text beside a moment, made one: of two, both are as exact as the less exact one is, `2026-07-30` a day."""
    if a.said == _MOMENT and b.text:
        exact = len(_moment(b.text))
        return a._replace(of=lambda row: a.of(row)[:exact])
    if b.said == _MOMENT and a.text:
        moment = _moment(a.text)
        return a._replace(of=lambda row: moment)
    return a


def _moment(text: str) -> str:
    if not _WRITTEN.fullmatch(moment := text.strip().replace("T", " ").removesuffix("Z")):
        raise _WrongError(
            f"{text!r} is no moment: write it like '2026-07', '2026-07-30' or '2026-07-30 12:00', in UTC"
        )
    return moment


def _known(value: Any) -> bool:
    return value is not None and value != ""


def _inside(a: _Part, b: _Part) -> Callable[[Row], bool]:
    """A text in a text or among words, or a value among several."""
    if (a.kind, b.kind) in (("text", "text"), ("text", "texts"), ("text", "choice"), ("number", "choice")):
        return lambda row: a.of(row) in b.of(row)
    return _cannot(a, b)


def _cannot(a: _Part, b: _Part) -> NoReturn:
    hint = ""
    for one, other in ((a, b), (b, a)):
        if one.kind == "texts" and other.kind == "text":
            hint = f"; write {other.said} in {one.said}"
    raise _WrongError(f"{a.said} is {_WORDS[a.kind]} and {b.said} {_WORDS[b.kind]}: they don't compare{hint}")
