"""What the benchmark writes and reads back, as plain JSON: recipes, truths, answers, records and figures."""

from typing import Any, NotRequired, TypedDict

from labrig.contents import Errors
from labrig.run_contents import LookContent


class RigRecipe(TypedDict):
    """From what a rig of a half is made again; with `linear`, a map of degree 1 is the whole of it."""

    half: str
    rig: str
    rig_seed: int
    linear: NotRequired[bool]


class BaseRecipe(RigRecipe):
    """From what a base model is made again: the rig that it means, and in which way it is a base of it."""

    kind: str
    seed: int
    points: NotRequired[int]
    form: NotRequired[str]
    scale: NotRequired[float]


Truth = TypedDict(
    "Truth",
    {
        "class": str,
        "half": str,
        "seed": int,
        "effects": list[str],
        "laws": list[str],
        "rig": str,
        "base_kind": str,
        "verdict": str,
        "also": list[str],
        "without": list[str],
        "design": str,
        "captures": int,
        "floor": float,
    },
)
"""What a record keeps of what is hidden, and of what a right answer is."""


class WholeTruth(Truth):
    """All that is known of a campaign that was drawn; `truth.json` of `labrig bench draw`."""

    amplitudes: dict[str, float]
    strengths: dict[str, float]
    structural: float
    unit: str
    spoil: dict[str, float]
    base: BaseRecipe


class JudgedEffect(TypedDict):
    """What is judged of an effect that a diagnosis considered."""

    effect: str
    probability: float
    size: NotRequired[float | None]
    size_sd: NotRequired[float | None]


class JudgedAlone(TypedDict):
    """What is judged of an effect that was fitted by itself."""

    effect: str
    heldout_error: float
    drop: float | None
    probability: float | None


class Answer(TypedDict):
    """What is judged of a diagnosis, or of another method's answer."""

    verdict: str
    effects: list[str]
    rivals: NotRequired[list[Any] | None]
    probability: NotRequired[float | None]
    error: NotRequired[Errors | None]
    effects_considered: NotRequired[list[JudgedEffect]]
    ranking: NotRequired[list[JudgedAlone]]
    error_text: NotRequired[str]


class Fresh(TypedDict):
    """Errors on a programme that no model has seen, and by how much the error fell."""

    drop: float | None
    base: NotRequired[float]
    model: NotRequired[float]
    floor: NotRequired[float]


class Answered(TypedDict):
    """An answer, and by how much the error falls with it; a method that learns without names `names_nothing`."""

    answer: Answer
    drop: NotRequired[float | None]
    fresh: NotRequired[Fresh | None]
    names_nothing: NotRequired[bool]


class Judged(Answered):
    """An answer with the judgement of it."""

    right: bool
    near: bool
    false_alarm: bool
    wrongly_sure: list[str]


class Record(Judged):
    """A line of campaigns.jsonl: one campaign, drawn, diagnosed and judged."""

    key: str
    truth: Truth
    seconds: float
    baselines: NotRequired[dict[str, Judged]]
    baselines_failed: NotRequired[str]


class Interval(TypedDict):
    """A value and its 95 % interval."""

    value: float
    low: float
    high: float


class Figure(Interval):
    """A figure of the benchmark, and of how many campaigns; a share has their `count` too."""

    of: int
    count: NotRequired[int]
    few: NotRequired[bool]


class Spread(TypedDict):
    """Median and tenth percentile over campaigns."""

    campaigns: int
    median: float
    p10: float


class WrongAnswer(TypedDict):
    """A campaign that was not answered rightly."""

    key: str
    truth: list[str]
    answer: str


class BaselineFigures(TypedDict):
    """How another method did in a class; shares are None of one that names nothing."""

    right: float | None
    false_alarms: float | None
    fresh_drop: Spread | None


class ClassFigures(TypedDict):
    """The figures of a class; None where a figure has no meaning there."""

    campaigns: int
    right: Figure | None
    named_among: Figure | None
    wrong_sure: Figure | None
    false_alarms: Figure | None
    verdicts: dict[str, int]
    drop: Spread | None
    fresh_drop: Spread | None
    seconds: float
    baselines: dict[str, BaselineFigures]
    wrong: NotRequired[list[WrongAnswer]]


class PartFigures(TypedDict):
    """The figures of a part: an effect, a law, a rig or a base."""

    name: list[str]
    right: Figure | None
    true_sure: Figure | None
    true_possible: Figure | None
    wrong_sure: Figure | None


class Totals(TypedDict):
    """The figures of all campaigns of a half."""

    right: Figure | None
    true_sure: Figure | None
    true_possible: Figure | None
    wrong_sure: Figure | None
    unknown_recall: Figure | None
    verdict_ece: Figure | None
    verdict_brier: Figure | None
    effect_ece: Figure | None
    effect_brier: Figure | None
    fresh_drop_p10: Figure | None
    fresh_drop_median: Figure | None
    black_box_fresh_drop: Spread | None


class GoalFigure(TypedDict):
    """A goal, the figure that it is about, and whether it is met."""

    what: str
    goal: str
    percent: bool
    figure: Figure
    status: str


class HalfFigures(TypedDict):
    """The figures of one half; of the exam nothing by law, rig or base."""

    campaigns: int
    classes: dict[str, ClassFigures]
    totals: Totals
    effects: list[PartFigures]
    failures: int
    goals: list[GoalFigure]
    confusion: NotRequired[dict[str, dict[str, int]]]
    laws: NotRequired[list[PartFigures]]
    rigs: NotRequired[list[PartFigures]]
    bases: NotRequired[list[PartFigures]]


class HalvesDifference(TypedDict):
    """Right verdicts of the two halves side by side."""

    what: str
    development: Figure | None
    exam: Figure | None
    difference: Interval
    status: str


class BenchSummary(TypedDict):
    """The content of summary.json."""

    campaigns: int
    halves: dict[str, HalfFigures]
    difference: NotRequired[list[HalvesDifference]]


class Settling(TypedDict):
    """What it took to settle a doubt in one way; None where it was not settled."""

    strategy: str
    settled: bool
    captures: int | None
    minutes: float | None
    verdict: str
    effects: list[str]
    rivals: list[str]


class SettleTruth(TypedDict):
    """What a record of settle.jsonl keeps of its campaign."""

    effects: list[str]
    design: str
    captures: int


class SettleRecord(Settling):
    """A line of settle.jsonl."""

    seed: int
    truth: SettleTruth


class WatchedLook(LookContent):
    """A look at a growing campaign; `acted`: how large each hidden effect was by then, in floors."""

    rivals: list[str]
    acted: dict[str, float]


class StoppingRecord(TypedDict):
    """A line of stopping.jsonl: a campaign, looked at as it grows."""

    key: str
    truth: Truth
    looks: list[WatchedLook]
