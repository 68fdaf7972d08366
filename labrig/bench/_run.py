"""One blind campaign after another: draw, diagnose, judge; many at a time, and again where it was left."""

import json
import os
import tempfile
import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, cast

import numpy as np

from labrig._durable import write_whole
from labrig._errors import LabrigError
from labrig._executor import Executor
from labrig._near import meant
from labrig.bench._bases import own_error
from labrig.bench._classes import CLASSES
from labrig.bench._draw import Campaign, draw
from labrig.bench._files import write_model
from labrig.bench._halves import DRAWN_FROM, make_rig
from labrig.bench._judge import is_false_alarm, is_near, is_right, wrongly_sure
from labrig.bench._lines import adding_lines, read_lines
from labrig.bench.records import Answer, Answered, Fresh, Judged, Record, Truth
from labrig.contents import Errors
from labrig.effects import library

RECORDS = "campaigns.jsonl"
LIBRARY = "library.json"
_TIED_TO_A_SESSION = ("drift", "marker_slip")  # what happened in one campaign says nothing of the next


_OF_TRUTH = (
    "class",
    "half",
    "seed",
    "effects",
    "laws",
    "rig",
    "base_kind",
    "verdict",
    "also",
    "without",
    "design",
    "captures",
    "floor",
)


def run_one(
    name: str,
    seed: int,
    half: str = "development",
    baselines: bool = True,
    without: tuple[str, ...] = (),
) -> Record:
    """Draw, diagnose and judge one campaign; the record is plain JSON. A crash is an answer too, a wrong one."""
    campaign = draw(name, seed, half, without)
    truth = cast(Truth, {k: campaign.truth[k] for k in _OF_TRUTH})
    beside: dict[str, Judged] = {}
    failed = ""
    with tempfile.TemporaryDirectory(prefix="labrig-bench-", ignore_cleanup_errors=True) as folder:
        path = write_model(campaign, Path(folder))
        began = time.perf_counter()
        try:
            said = _ask(campaign, path)
        except Exception as error:
            said: Answered = {"answer": {"verdict": "error", "effects": [], "error_text": _what(error)}}
        seconds = round(time.perf_counter() - began, 2)
        if baselines:
            try:
                others = _baselines(campaign, path, seed)
                beside = {name: _judged(truth, other) for name, other in others.items()}
            except Exception as error:
                failed = _what(error)
    record: Record = {
        "key": key_of(half, name, seed),
        "truth": truth,
        **_judged(truth, said),
        "seconds": seconds,
    }
    if baselines:
        record["baselines"] = beside
    if failed:
        record["baselines_failed"] = failed
    return record


def _what(error: Exception) -> str:
    return f"{type(error).__name__}: {error}"


def _judged(truth: Truth, said: Answered) -> Judged:
    answer = said["answer"]
    return {
        **said,
        "right": is_right(truth, answer),
        "near": is_near(truth, answer),
        "false_alarm": is_false_alarm(truth, answer),
        "wrongly_sure": sorted(wrongly_sure(truth, answer)),
    }


def _ask(campaign: Campaign, path: Path) -> Answered:
    """The diagnosis of a campaign, cut down to what is judged, and by how much the error falls."""
    from labrig.diagnosis import diagnose
    from labrig.model import Model

    result = diagnose(campaign.dataset, Model.load(path), without=campaign.truth["without"])
    summary = result.summary
    answer: Answer = {
        "verdict": summary["verdict"],
        "effects": summary["effects"],
        "rivals": summary.get("rivals"),
        "probability": summary.get("probability"),
        "error": summary.get("error"),
    }
    if (considered := summary.get("effects_considered")) is not None:
        answer["effects_considered"] = [
            {
                "effect": entry["effect"],
                "probability": entry["probability"],
                "size": entry.get("size"),
                "size_sd": entry.get("size_sd"),
            }
            for entry in considered
        ]
    answer["ranking"] = [
        {
            "effect": entry["effect"],
            "heldout_error": entry["heldout_error"],
            "drop": entry["drop"],
            "probability": entry.get("probability"),
        }
        for entry in (summary.get("ranking") or [])[:5]
    ]
    error = summary.get("error") or Errors()
    best = max(error.get("floor") or 0.0, error.get("ceiling") or 0.0)
    said: Answered = {"answer": answer, "drop": _drop(error.get("base"), error.get("model"), best)}
    tied = set(campaign.truth["effects"]) & set(_TIED_TO_A_SESSION)
    if summary.get("effects") and result.improved is not None and campaign.base is not None and not tied:
        said["fresh"] = _fresh(campaign, path, result.improved)
    return said


def _drop(base: float | None, model: float | None, floor: float) -> float | None:
    """(base - model) / (base - floor): one where the model is as good as the measurements."""
    if base is None or model is None or base <= floor:
        return None
    return float((base - model) / (base - floor))


def _fresh(campaign: Campaign, path: Path, improved: Any) -> Fresh | None:
    """Errors on the fresh programme: base, improved model, floor and drop; None where the model cannot say."""
    from labrig.bench._learner import capture_error
    from labrig.effects import rows_of
    from labrig.model import Model

    rows, noisier = rows_of(campaign.fresh), make_rig(campaign.truth["base"]).noisier
    try:
        base = capture_error(rows, Model.load(path).context(rows).base, noisier)
        model = capture_error(rows, improved.context(rows).base, noisier)
    except LabrigError:
        return None
    how = campaign.truth["spoil"]
    floor = float(np.hypot(how["capture"], how["row"] / np.sqrt(np.mean(np.bincount(rows.capture)))))
    best = float(np.hypot(floor, own_error(campaign.truth["base"], rows.actuation)))
    drop = _drop(base, model, best) if base > 1.1 * best else None  # nothing to speak of was to be won
    return {"base": base, "model": model, "floor": floor, "drop": drop}


def _baselines(campaign: Campaign, path: Path, seed: int) -> dict[str, Answered]:
    """The baselines' answers, and the black box's drop on the fresh programme."""
    from labrig.bench._baselines import run_baselines
    from labrig.bench._learner import capture_error, learned_error
    from labrig.effects import rows_of
    from labrig.model import Model

    model = Model.load(path)
    rows = rows_of(campaign.dataset)
    context = model.context(rows)
    library = {k: v for k, v in model.library().items() if k not in campaign.truth["without"]}
    answers = run_baselines(context, library, np.random.default_rng(seed))
    out: dict[str, Answered] = {k: {"answer": v} for k, v in answers.items()}
    if campaign.base is not None:
        fresh = rows_of(campaign.fresh)
        fresh_base = model.context(fresh).base
        noisier = make_rig(campaign.truth["base"]).noisier
        learned = learned_error(rows, context.base, fresh, fresh_base, noisier)
        nothing: Answer = {
            "verdict": "unknown" if campaign.truth["effects"] else "nothing_missing",
            "effects": [],
        }
        if learned is not None:
            drop = _drop(capture_error(fresh, fresh_base, noisier), learned, campaign.truth["floor"])
            out["black box"] = {"answer": nothing, "fresh": {"drop": drop}, "names_nothing": True}
    return out


def key_of(half: str, name: str, seed: int) -> str:
    """What a campaign is called in the records."""
    return f"{half}:{name}:{seed}"


def plan(
    classes: Iterable[str], count: int | None, seed: int, halves: Iterable[str] = ("development",)
) -> list[tuple[str, str, int]]:
    """(half, class, seed) of every campaign; without `count`, as many of each class as its figures need."""
    names, out = list(classes), []
    for half in halves:
        if half not in DRAWN_FROM:
            raise LabrigError(f"bench: there is no half '{half}' (known: {', '.join(DRAWN_FROM)})")
        for name in names:
            if name not in CLASSES:
                raise LabrigError(f"bench: there is no class '{name}' (known: {', '.join(CLASSES)})")
            out += [(half, name, seed + k) for k in range(count or CLASSES[name].usual)]
    return out


def read_records(folder: Path) -> list[Record]:
    """The campaigns that are done, each once; a last line that was cut, and records of the benchmark before it had
    halves, are left out.
    """
    once: dict[str, Record] = {}
    for record in read_lines(folder / RECORDS):
        if "half" in record["truth"]:
            once.setdefault(record["key"], record)
    return list(once.values())


def run_blind(
    todo: list[tuple[str, str, int]],
    folder: Path,
    jobs: int = 2,
    resume: bool = False,
    baselines: bool = True,
    without: tuple[str, ...] = (),
    cluster: str | None = None,
) -> Iterator[Record]:
    """Run campaigns, `jobs` at a time, and yield each record as it is done and written to campaigns.jsonl.

    With `resume`, campaigns that are in the file already are skipped (and not yielded). `cluster`: the address of
    a Dask scheduler, whose workers then take the place of local processes. Raises `LabrigError` if the folder
    holds campaigns and `resume` is not set, or holds some that another library was asked about, and if there is no
    effect of a name in `without`.
    """
    known = library()
    for name in without:
        if name not in known:
            raise LabrigError(f"bench: there is no effect {name!r} to leave out{meant(name, known)}")
    done = {record["key"] for record in read_records(folder)}
    if done and not resume:
        raise LabrigError(
            f"{folder / RECORDS} holds {len(done)} campaigns: add --resume, or take another --out"
        )
    _same_library(folder / LIBRARY, without)
    left = [one for one in todo if key_of(*one) not in done]
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # inherited by the workers: one core each
    tasks = [(name, seed, half, baselines, without) for half, name, seed in left]
    with Executor(jobs, cluster) as executor, adding_lines(folder / RECORDS) as add:
        for _, record in executor.map(_run_task, tasks):
            add(record)
            yield record


def _run_task(task: tuple[str, int, str, bool, tuple[str, ...]]) -> Record:
    """`run_one` with its arguments in one, as executors hand them out."""
    return run_one(*task)


def _same_library(path: Path, without: tuple[str, ...]) -> None:
    """Write down which effects the library lacks, or see that the campaigns that are there were asked without the same;
    raises `LabrigError` otherwise.
    """
    asked = sorted(without)
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, json.dumps({"without": asked}) + "\n")
    elif (begun := json.loads(path.read_text(encoding="utf-8"))["without"]) != asked:
        how = f"--without {','.join(begun)}" if begun else "the whole library"
        raise LabrigError(f"{path.parent} was begun with {how}: go on with the same, or take another --out")
