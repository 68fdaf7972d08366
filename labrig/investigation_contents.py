"""The content of investigation.json, as those see it who read it: its rounds, what it does now, how it ended."""

from typing import Any, NotRequired, TypedDict

from labrig.contents import Errors


class Round(TypedDict):
    """A round of an investigation."""

    round: int
    programme: str
    run: str
    minutes: float
    captures: int
    verdict: str
    effects: list[str]
    rivals: list[str]
    probability: float | None
    error: Errors | dict[str, None]
    report: NotRequired[str]
    given: NotRequired[list[str]]


class Confirmation(TypedDict):
    """Errors on captures that were recorded after the verdict."""

    effects: list[str]
    before: float
    after: float
    floor: float
    drop: float
    run: str


class InvestigationSettings(TypedDict):
    """What an investigation was asked for."""

    rig: str
    model: str
    budget_min: float
    out: str
    seed: int
    highest: float
    realtime: bool
    runs: list[str]
    model_sha256: NotRequired[str]


class Doing(TypedDict):
    """What an investigation that is under way does now: measuring, diagnosing, planning or fitting.

    `minutes` are those that the run of this round takes, `since_s` is the moment at which this began (UTC).
    """

    what: str
    round: int
    programme: str
    run: str
    minutes: float
    captures: int
    since_s: float


class InvestigationContent(TypedDict):
    """The content of investigation.json; `now` is there while it is under way."""

    state: str
    conclusion: str
    units: str
    minutes: float
    budget_min: float
    rounds: list[Round]
    confirmation: Confirmation | None
    waterfall: list[Any]
    model: str | None
    warnings: list[str]
    now: NotRequired[Doing | None]
    settings: InvestigationSettings
