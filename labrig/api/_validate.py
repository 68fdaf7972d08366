"""validate: targets realised on a rig, and how far what came out is from them and from what was predicted."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from labrig._errors import LabrigError
from labrig._paths import check_there, path_of
from labrig.api._as_file import WANTED
from labrig.api._ik import targets_of
from labrig.api._inputs import AnyPath, names_of
from labrig.shape_contents import Realisation

if TYPE_CHECKING:
    from pandas import DataFrame

    from labrig.api._as_file import ShapeModelGiven
    from labrig.ik import Outcome

FORMS = ("warp", "effects")
"""What a validation may leave out of its model, to see what it is worth."""


@dataclass(frozen=True, repr=False)
class Validation:
    """What a run of the procedure validate came to: every target with each form of the model.

    `realisations` has a row for each: mean distances in mm of what the rig can do at best (`hardware`), of what was
    `predicted` and `realised` from the target, of the best that refining came to (`refined`), of what was realised from
    what was predicted (`apart`) and of the markers from theirs (`markers`); NaN where it was not measured.
    """

    run: Path
    _outcomes: "list[Outcome]" = field(repr=False)

    @property
    def summary(self) -> dict[str, "list[Realisation]"]:
        """All of it as plain values: the content of validation.json."""
        return {"realisations": [outcome.summary() for outcome in self._outcomes]}

    @property
    def realisations(self) -> "DataFrame":
        """`target`, `model`, then mean distances in mm: `hardware`, `predicted`, `realised`, `refined` and so on."""
        from pandas import DataFrame

        columns = {
            "hardware": "hardware_mm",
            "predicted": "predicted_mm",
            "realised": "realised_mm",
            "apart": "realised_against_predicted_mm",
            "markers": "markers_against_predicted_mm",
        }
        rows = []
        for one in self.summary["realisations"]:
            means = {name: one[key]["mean"] if one[key] else float("nan") for name, key in columns.items()}
            again = [more["realised_mm"]["mean"] for more in one["refined"] if more["realised_mm"]]
            means["refined"] = min([*again, means["realised"]]) if again else float("nan")
            rows.append({"target": one["target"], "model": one["model"], **means})
        return DataFrame(rows)

    def save(self, folder: AnyPath | None = None) -> Path:
        """Write validation.json and report.html into `folder`, by default the run's; returns the report's path."""
        from labrig._json import EXACT, write_json
        from labrig.view import write_validation

        folder = Path(folder) if folder is not None else self.run
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / "validation.json"
        write_json(self.summary, path, EXACT)
        return write_validation(self._outcomes, self.run, folder)

    def __repr__(self) -> str:
        from labrig.ik import WHOLE

        table = self.realisations
        whole: Any = table[table["model"] == WHOLE]
        realised, refined = (whole[name].dropna().tolist() for name in ("realised", "refined"))
        form = f" with {WHOLE}" if len(set(table["model"])) > 1 else ""
        mean_mm = sum(realised) / max(len(realised), 1)
        then = f", {sum(refined) / len(refined):.3g} mm after refining" if refined else ""
        far = (
            f"{mean_mm:.3g} mm from the target on the mean{form}{then}" if realised else "nothing was scanned"
        )
        return f"Validation: {len(table)} realisations of {table['target'].nunique()} targets, {far}"

    def _repr_html_(self) -> str:
        from html import escape

        table = self.realisations.to_html(index=False, float_format="{:.3f}".format, border=0)
        return f"<p><b>{escape(repr(self))}</b></p>{table}"


def validate(
    targets: Any,
    rig: Any = None,
    model: "ShapeModelGiven | None" = None,
    *,
    out: AnyPath | None = None,
    without: tuple[str, ...] = (),
    refine: int = 0,
    unit: str = "",
    seed: int = 0,
    realtime: bool = False,
) -> Validation:
    """Realise targets on a rig and measure what came out; or read a run that did, as `validate("runs/validated")`.

    Args:
        targets: target surfaces' files; or, alone, the folder of a run of the procedure validate.
        rig: a rig.yaml's path, or what `labrig.load_rig` gives.
        model: its file, what `labrig.Model.load` gives, or what `train_forward` or `train_sim2real` has just given:
            such a model is written beside the run's folder, as `validated-model.pt`, since a report asks it again.
        out: the run's folder; by default a new one in ./runs.
        without: "warp" or "effects": forms of the model to try as well, without these.
        refine: how often a realisation may be corrected by its own scan.
        unit: of the targets, where their files do not say.
        seed: of everything that is random.
        realtime: let a rig that is simulated here take as long as a real one.

    Raises:
        LabrigError: a file does not exist or fit, a limit would be broken.
        DeviceError: a device failed; the chambers are vented.

    Example:
        >>> found = labrig.validate("body.ply", "rig.yaml", "forward.pt", out="runs/validated")
        >>> list(found.realisations["target"])
        ['body.ply']
        >>> print(found.realisations["realised"][0] < 2.0)  # mm, on the mean
        True
    """
    from labrig.api._run import made, new_folder, run
    from labrig.ik import outcomes

    if model is None and rig is None and isinstance(targets, str | Path):
        return Validation(Path(targets), outcomes(targets))
    if model is None or rig is None:
        raise LabrigError(
            "a validation needs targets, the rig and the model; or the folder of a run that did it"
        )
    without = tuple(names_of(without, "a form to leave out")) if without else ()
    check_forms(without)
    files = targets_of(targets)
    check_there(files)
    out = Path(out) if out is not None else new_folder(made("validate", {}))
    file = _kept_file(model, out)
    parameters = {
        "targets": tuple(str(path.resolve()) for path in files),
        "model": str(file.resolve()),
        "refine": refine,
        "without": without,
        "unit": unit,
    }
    try:
        folder = run("validate", rig, out=out, seed=seed, realtime=realtime, **parameters)
    except BaseException:
        if file.name == _kept_name(out) and not out.exists():  # nothing was begun that asks it again
            file.unlink()
        raise
    found = Validation(folder, outcomes(folder))
    found.save()
    return found


def check_forms(without: Sequence[str], called: str = "without") -> None:
    """Raise `LabrigError` for a form of a model to leave out that there is not."""
    for form in without:
        if form not in FORMS:
            raise LabrigError(f"{called} {form}: there are {' and '.join(FORMS)}")


def validate_arguments(
    targets: Sequence[Path], model: Path, without: Sequence[str] = (), refine: int = 0, unit: str = ""
) -> list[str]:
    """The parameters of the procedure as `labrig run validate` takes them; raises `LabrigError` for wrong ones."""
    check_forms(without, "--without")
    for path in (*targets, model):
        if "," in str(path):
            raise LabrigError(f"{path}: a name without a comma is needed")
    check_there((*targets, model))
    files = ",".join(str(path.resolve()) for path in targets)
    words = ["--targets", files, "--model", str(model.resolve()), "--refine", str(refine)]
    words += ["--without", ",".join(without)] if without else []
    return words + (["--unit", unit] if unit else [])


def _kept_name(run_folder: Path) -> str:
    return f"{run_folder.name}-model.pt"


def _kept_file(given: "ShapeModelGiven", run_folder: Path) -> Path:
    """The file of a model, for as long as the run's folder: one that was just learnt is written beside that.

    Raises `LabrigError` for anything else, for a file that is not there, and where another one has the name.
    """
    from labrig.model import Model
    from labrig.surrogate import ForwardModel, Trained, TrainedWarp, WarpedModel, save_model

    if isinstance(given, Trained | TrainedWarp):
        given = given.model
    if isinstance(given, ForwardModel | WarpedModel):
        path = run_folder.with_name(_kept_name(run_folder))
        if path.exists():
            raise LabrigError(
                f"{path} is there already, and the model would be written there: name another out"
            )
        path.parent.mkdir(parents=True, exist_ok=True)
        save_model(given, path)
        return path
    if isinstance(given, Model):
        if given.path is None:
            raise LabrigError(
                "the model is not saved yet, and the report reads it from its file: save it first (model.save)"
            )
        given = given.path
    path = path_of(given, "a model", WANTED)
    if not path.is_file():
        raise LabrigError(f"{path} does not exist")
    return path
