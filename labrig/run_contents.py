"""What a run keeps and says as plain values: results of its steps, how it stands, what a live diagnosis makes of it."""

from collections.abc import Sequence
from typing import Any, NotRequired, Required, TypedDict

from labrig.contents import ProgrammePoint


class LookContent(TypedDict):
    """A look at a campaign that goes on; errors that are not known are None."""

    captures: int
    minutes: float
    verdict: str
    effects: list[str]
    probability: dict[str, float]
    by_evidence: NotRequired[dict[str, float]]
    base: float | None
    error: float | None
    floor: float | None
    ceiling: float | None
    units: str


class RangeContent(TypedDict):
    """The pressures that what is proposed keeps to, (C,) kPa, and how fast the rig changes them, (C,) kPa/s."""

    low_kpa: Sequence[float]
    high_kpa: Sequence[float]
    slew_kpa_s: Sequence[float]


class LiveQuestion(TypedDict):
    """What the process of a live diagnosis is asked: a look after so many captures; with a range, also what is next."""

    captures: int
    adapt: NotRequired[RangeContent]


class LiveAnswer(TypedDict, total=False):
    """What the process of a live diagnosis says of a question: its look, what to measure next, or what went wrong."""

    look: LookContent
    points: list[ProgrammePoint]
    trouble: str


class Advice(LiveAnswer, total=False):
    """What an adviser says between two steps: `say` and `trouble` go into the log, `stop` is why it is enough."""

    say: str
    asked: int
    stop: str
    probability: dict[str, float]


class StepResult(TypedDict, total=False):
    """What the log keeps of a step that is done; each kind of step has its own fields."""

    time_s: float
    took_s: float
    speed_mm_s: float
    fastest_mm_s: float
    pressure_error_kpa: float
    frames: int
    frame_ns: list[int] | None
    frames_lost: int
    samples: int
    sample_ns: list[int] | None
    seen: float | None
    files: list[str]
    sha256: str
    vertices: int
    triangles: int
    registration_error_mm: float
    unit: str
    pressure_kpa: list[float]
    content: Advice
    commanded_kpa: list[float]
    reached_kpa: list[float | None]
    missed: list[str]


class Facts(TypedDict, total=False):
    """What a run or a guard that can be asked says of itself: the rig, its link, the folder of the run."""

    rig: Required[str]
    link: Required[str]
    run: str
    folder: str
    procedure: str
    rig_folder: str


class Asking(TypedDict, total=False):
    """What a run or a guard is asked: what to do, why, and what is known already."""

    do: Required[str]
    why: str
    since_s: float
    event: int
    capture: int
    actuation: int


class VentContent(TypedDict):
    """A confirmed vent: what each chamber reads, (C,) kPa, and how long it took."""

    pressure_kpa: list[float]
    took_s: NotRequired[float]


class RunState(TypedDict, total=False):
    """How a run stands, as far as it has come; `step` is as `Step.to_dict` gives it, with its index."""

    chambers: list[str]
    limits_kpa: list[list[float]]
    markers: list[str]
    rest_mm: list[Any] | None
    step: dict[str, Any]
    steps_done: int
    looks: list[LookContent]
    progress: dict[str, Any]
    ended: str


class PressureHistory(TypedDict):
    """Pressures since somebody last asked, kPa."""

    time_s: list[float]
    measured_kpa: list[list[float | None]]
    commanded_kpa: list[list[float | None]]


class RunStatus(Facts, RunState, total=False):
    """What a run answers to who asks how it stands."""

    paused: bool
    commanded_kpa: list[float | None]
    measured_kpa: list[float | None] | None
    time_s: float | None
    position_mm: list[Any] | None
    history: PressureHistory
    events: list[list[Any]]
    vented_kpa: list[float | None] | None


class CaptureFacts(TypedDict):
    """A capture of a run that goes on: which step, when, and after which actuation."""

    step: int
    time_s: float
    hold_s: float
    event: int
    label: str
    repeat: str


class CaptureContent(CaptureFacts):
    """The same with its numbers: set-points and pressures, kPa, and positions, mm."""

    values: list[float | None]


class NewCaptures(TypedDict):
    """What came after so many captures and actuations; an actuation is a time and its set-points."""

    captures: list[CaptureContent]
    actuations: list[list[Any]]


class CaptureError(TypedDict):
    """The error of a capture: root mean square per coordinate, mm."""

    step: int
    time_s: float
    rms: float


class LastCapture(TypedDict):
    """Where the markers of the last capture were and should be, (M, 3) mm."""

    step: int
    label: str
    measured_mm: Any
    predicted_mm: Any


class LiveError(TypedDict, total=False):
    """How far a model is from a run so far, or why that cannot be said."""

    captures: list[CaptureError]
    rms: float | None
    last: LastCapture
    error: str
