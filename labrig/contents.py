"""The content of the JSON files in which labrig keeps results, as those see it who read one.

What an older version may not have written, or only some commands write, is not required; docs/reference says what each
field means.
"""

from typing import Any, NotRequired, Required, TypedDict


class Errors(TypedDict, total=False):
    """Root mean square errors: those that a command has; a file has null for what is not a number."""

    base: float
    model: float
    floor: float
    ceiling: float


class RunNamed(TypedDict):
    """A run that a result is about: its path, what it is recognised by, and how many captures it had then."""

    run: str
    id: str
    captures: NotRequired[int]
    ruled_out: NotRequired[list[str]]


class About(TypedDict):
    """What a result is about: the runs that were recorded, and the model's file."""

    runs: list[RunNamed]
    model: str | None


class FloorSource(TypedDict):
    """Where the noise floor comes from: in words, and what each kind of repeat differs by."""

    how: str
    repeats: dict[str, float | None]


class Place(TypedDict):
    """A place where a model fails: its error, its share of what is explainable, and whether it is `clear`."""

    group: str
    name: str
    error: float
    share: NotRequired[float]
    clear: NotRequired[bool]


class TimesThere(TypedDict):
    """How often an effect was there that was called sure, of how many times."""

    there: int
    of: int


class Considered(TypedDict):
    """What a diagnosis says of one effect; of one that is sure also how often that was so, where it was counted."""

    effect: str
    probability: float
    call: str
    seen: NotRequired[bool]
    by_evidence: NotRequired[float]
    gone: NotRequired[float]
    share: NotRequired[float]
    size: NotRequired[float]
    size_sd: NotRequired[float]
    size_floors: NotRequired[float]
    size_sd_floors: NotRequired[float]
    track_record: NotRequired[TimesThere | None]


class Ranked(TypedDict):
    """One effect, fitted by itself."""

    effect: str
    form: str
    heldout_error: float
    drop: float | None
    se: NotRequired[float | None]
    probability: NotRequired[float]
    parameters: NotRequired[dict[str, Any]]


class ProbeNamed(TypedDict):
    """A probe of a programme, by its name, and what it separates in what time."""

    probe: str
    separates: NotRequired[str]
    times: NotRequired[int]
    minutes: NotRequired[float]


class Next(TypedDict, total=False):
    """What to measure next, in short; with `programme` where one was proposed.

    `unsettled` are the pairs, such as `creep from leak`, that the programme may not settle by itself.
    """

    separates: list[str]
    probes: list[str]
    programme: list[ProbeNamed]
    minutes: float
    captures: int
    why: str
    unsettled: list[str]


class CarriedOver(TypedDict):
    """An effect's values that were carried over: of the prior, of the runs, and of both together."""

    sources: list[str]
    z: float
    prior: list[float]
    prior_sd: list[float]
    data: list[float]
    data_sd: list[float]
    value: list[float]
    sd: list[float]
    runs: list[int]
    shrunk: list[float]
    between_runs: list[float]


class TrackRecord(TypedDict):
    """How many verdicts were right, of how many; and in how many all that they named was there."""

    right: int
    of: int
    there: NotRequired[int]


MANY_LEFT_OUT = 0.05
"""From this share of all values on, what is left out as mistaken is no rare mistake: something makes it."""


class HeldOff(TypedDict):
    """A marker or sensor that was left out through whole holds, and by how much it was off there at most."""

    name: str
    captures: list[int]
    error: float
    units: str


class Summary(TypedDict, total=False):
    """The content of diagnosis.json; of compare.json and improve.json those fields that they have."""

    verdict: str
    effects: list[str]
    probability: float
    track_record: TrackRecord | None
    rivals: list[str]
    together: list[str]
    effects_considered: list[Considered]
    units: Required[str]
    error: Required[Errors]
    error_by_unit: dict[str, Errors]
    where: Required[list[Place]]
    drop: float
    ranking: list[Ranked]
    next_experiment: Next | None
    carried_by: str | None
    unnamed: dict[str, float]
    unnamed_units: dict[str, str]
    floor: FloorSource
    left_out: list[HeldOff]
    left_out_share: float
    warnings: list[str]
    added: list[dict[str, Any]]
    prior: CarriedOver
    runs: list[RunNamed]
    model: str | None


class Compared(TypedDict):
    """A model of a comparison, and its error."""

    name: str
    file: str | None
    error: float


class Gap(TypedDict):
    """A difference between two models' errors, and its interval."""

    value: float
    low: float
    high: float


class Difference(Gap):
    """The whole difference: also its standard error, the blocks it is from, and the level of its interval."""

    sd: float
    blocks: int
    level: float


class PlaceGap(Gap):
    """Both errors of a place, their difference, and the model that is nearer there."""

    group: str
    name: str
    error: list[float]
    better: str | None


class Versus(TypedDict):
    """The content of comparison.json: two models on the same measurements."""

    units: str
    models: list[Compared]
    error: dict[str, float]
    error_by_unit: NotRequired[dict[str, dict[str, float]]]
    difference: Difference
    better: str | None
    where: list[PlaceGap]
    floor: NotRequired[FloorSource]
    warnings: list[str]
    runs: NotRequired[list[RunNamed]]


class HistoryRun(TypedDict):
    """A run of a rig's history; runs of one `kind` did the same programme."""

    run: str
    date: str
    procedure: str
    kind: str


class Quantity(TypedDict):
    """A reading over the runs that have it: the numbers of these `runs`, its values, and their standard deviations."""

    group: str
    name: str
    unit: str
    runs: list[int]
    value: list[list[float]]
    sd: list[float | None]


class HistoryChange(TypedDict):
    """A change of a quantity: from which run on, among which dates, and what it was before and is after."""

    group: str
    name: str
    unit: str
    shape: str
    begins: int
    date: str
    earliest: str
    latest: str
    noticed: int
    noticed_date: str
    before: list[float]
    after: list[float]
    amount: list[float]
    sd: float
    odds: float
    words: str
    since_fit: bool


class LeftOut(TypedDict):
    """A run that is left out, and why."""

    run: str
    why: str


class HistoryContent(TypedDict):
    """The content of history.json."""

    rig: str
    model: str | None
    fitted_until: str | None
    alpha: float
    runs: list[HistoryRun]
    quantities: list[Quantity]
    changes: list[HistoryChange]
    unconfirmed: list[str]
    left_out: list[LeftOut]


class ProgrammePoint(TypedDict):
    """A set-point of a programme, as the procedure `programme` takes it."""

    hold_s: float
    label: str
    pressure_kpa: NotRequired[dict[str, float]]
    repeat: NotRequired[str]
    note: NotRequired[str]
    by_hand: NotRequired[bool]


class ProbeRow(TypedDict):
    """A probe of a proposed experiment, and what it tells."""

    probe: str
    shows: str
    separates: str
    times: int
    minutes: float
    floors: NotRequired[float]
    nats: NotRequired[float]
    log10_bayes: NotRequired[float]


class Expected(TypedDict):
    """By what one explanation would be off if another is true."""

    true: str
    other: str
    apart: float
    floors: float
    settles: bool
    outlook: NotRequired[str]
    log10_bayes: NotRequired[float]


class ByHand(TypedDict):
    """What a person could do besides; where it rules the effect out, how many set-points to measure then, and how long
    that takes.
    """

    effect: str
    what: str
    points: bool
    captures: NotRequired[int]
    minutes: NotRequired[float]
    procedure: NotRequired[str]


class Proposed(TypedDict):
    """The content of next.json."""

    verdict: str
    separates: list[str]
    units: str
    actuation_units: str
    units_of: dict[str, str]
    minutes: float
    captures: int
    why: str
    probes: list[ProbeRow]
    expected: list[Expected]
    by_hand: list[ByHand]
    warnings: list[str]
    floor: float
    ruled_out: NotRequired[str]
    put_back: NotRequired[str]
    rig: NotRequired[str]
    procedure: NotRequired[str]
