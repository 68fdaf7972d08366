"""The content of JSON files about target shapes: the pressures that realise them, and how near they came."""

from typing import NotRequired, TypedDict


class Offsets(TypedDict):
    """Distances that remain, mm: mean, 95 %, the largest; None where they are not known."""

    mean: float | None
    p95: float | None
    max: float | None


class GapContent(TypedDict):
    """A part of a target that stays away: how far, where, how large, and which chamber's limit that is; in `words`."""

    depth_mm: float | None
    middle_mm: list[float | None]
    uv: list[float | None]
    area_share: float
    chamber: str
    limit: str
    words: str


class SolvedShape(TypedDict):
    """The pressures that realise a target, kPa, its place in the rig's frame, and what remains."""

    pressure_kpa: dict[str, float]
    sd_kpa: dict[str, float | None]
    at_limit: list[str]
    rotation: list[list[float]]
    translation_mm: list[float]
    distance_mm: Offsets
    share: float
    iterations: int
    starts: int
    time_ms: float
    prepare_ms: float
    compile_ms: float
    gaps: list[GapContent]
    inverted: bool
    notes: list[str]


class PathContent(TypedDict):
    """Set-points one after the other, kPa, and how long each is held, s."""

    name: str
    setpoints_kpa: list[list[float]]
    holds_s: list[float]


class SolvedTarget(SolvedShape):
    """A target of ik.json, with the distances that were measured of it, mm.

    `unit` is what was said of its file, None where nothing was; `limits_kpa` lowest and highest pressure of a chamber.
    """

    target: str
    unit: str | None
    limits_kpa: dict[str, list[float]]
    measured_mm: dict[str, float | None]
    path: NotRequired[PathContent]


class SolvedContent(TypedDict):
    """The content of ik.json: the model's file, and each target with its pressures or what is wrong with it."""

    model: str
    targets: list["SolvedTarget | UnsolvedTarget"]


class UnsolvedTarget(TypedDict):
    """A target without pressures, and why."""

    target: str
    error: str


class Distances(TypedDict):
    """Distances in mm: mean, 95 %, the largest, and the mean with its sign."""

    mean: float
    p95: float
    max: float
    signed: float


class Refined(TypedDict):
    """A realisation that was corrected by its own scan."""

    pressure_kpa: list[float]
    realised_mm: Distances | None


class Registered(TypedDict):
    """How a scan was registered; `sd_mm` is None where it may slide along the surface."""

    rms_mm: float
    share: float
    sd_mm: float | None
    iterations: int


class Realisation(TypedDict):
    """One target with one form of the model, as validation.json has it.

    `compared`: the share of the target, where the model's surface is opposite, that the scan shows, 0 to 1.
    """

    target: str
    model: str
    path: str
    pressure_kpa: list[float]
    hardware_mm: Distances | None
    predicted_mm: Distances | None
    realised_mm: Distances | None
    realised_against_predicted_mm: Distances | None
    markers_against_predicted_mm: Distances | None
    compared: float | None
    registration: Registered | None
    refined: list[Refined]
    scans: int
