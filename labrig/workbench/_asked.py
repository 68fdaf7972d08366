"""What requests may ask for: a field has one kind wherever it is asked for, and is checked in one place."""

from typing import Any

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat


class _Chosen(BaseModel):
    """What a column of a dropped table means: a `Meaning`."""

    model_config = ConfigDict(coerce_numbers_to_str=True)
    column: str | int
    part: str = ""
    name: str = ""
    unit: str = ""
    min: str = ""
    max: str = ""
    marker: str = ""
    axis: str = ""


class Asked(BaseModel):
    """The fields of requests, each of which may be left out; others are left to whoever knows them."""

    model_config = ConfigDict(coerce_numbers_to_str=True, extra="allow")
    run: str = ""
    model: str = ""
    name: str = ""
    text: str = ""
    effect: str = ""
    effects: str = ""
    base: str = ""
    a: str = ""
    b: str = ""
    table: str = ""
    mapping: str = ""
    out: str = ""
    procedure: str = ""
    plan: str = ""
    diagnose: str = ""
    seed: str = ""
    minutes: str = ""
    budget_min: str = ""
    highest: str = ""
    target: str = ""
    unit: str = ""
    rig: str = ""
    file: str = ""
    tags: list[str] = []
    runs: list[str] = []
    others: list[str] = Field([], alias="with")
    arguments: list[str] = []
    without: list[str] = []
    header: list[str] = []
    chosen: list[_Chosen] = []
    form: dict[str, Any] = {}
    since_s: FiniteFloat = 0.0
    event: int = 0
