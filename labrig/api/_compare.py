"""compare: a model as it stands against measurements, or two models against the same ones."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, overload

from labrig._errors import LabrigError
from labrig.api._answer import Answer, ModelAnswer
from labrig.api._inputs import model_of, runs_of
from labrig.contents import Versus

if TYPE_CHECKING:
    from collections.abc import Callable

    from pandas import DataFrame

    from labrig.diagnosis import VersusResult  # noqa: F401 - ruff does not look into the base class
    from labrig.model import Model
    from labrig.view import Figure


class Comparison(ModelAnswer):
    """How far a model is from measurements, and where: `error["model"]` against `error["floor"]`.

    Here `model` is the model that was given; in a diagnosis that is `base`.
    """

    name: ClassVar[str] = "compare"


class ModelComparison(Answer["VersusResult"]):
    """Two models on the same measurements: which is nearer, by how much, and where.

    `models` are their names, `error` has one entry for each and the `floor`; `difference` is the first model's error
    minus the second's, `interval` its 95 % interval; `better` is the name of the nearer one. In `fields` `base` is the
    first model's prediction and `model` the second's.
    """

    name: ClassVar[str] = "comparison"

    @property
    def summary(self) -> Versus:
        """All of it as plain values: the content of comparison.json."""
        return self._result.summary

    @property
    def models(self) -> list[str]:
        """The models' names: those of their files, in full where these are the same."""
        return [str(model["name"]) for model in self.summary["models"]]

    @property
    def difference(self) -> float:
        """Error of the first model minus error of the second, in `units`; above zero the second is nearer."""
        return float(self.summary["difference"]["value"])

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % interval of `difference`, in `units`; NaN where the run has too few captures for one."""
        found = self.summary["difference"]
        return float(found["low"]), float(found["high"])

    @property
    def better(self) -> str | None:
        """The name of the model that is nearer to the measurements; None where this run cannot tell."""
        return self.summary["better"]

    @property
    def where(self) -> "DataFrame":
        """A row for each place, those that differ most first.

        Columns: `group`, `name`, both errors by the models' names, `difference`, its interval `low` to `high`, all in
        `units`, and `better`. Intervals of one group hold together.
        """
        from pandas import DataFrame

        rows = [
            {"group": row["group"], "name": row["name"]}
            | dict(zip(self.models, row["error"], strict=True))
            | {"difference": row["value"], "low": row["low"], "high": row["high"], "better": row["better"]}
            for row in self.summary["where"]
        ]
        return DataFrame(rows, columns=["group", "name", *self.models, "difference", "low", "high", "better"])

    def headline(self) -> str:
        """Which model is nearer and by how much, or that this run cannot tell."""
        from labrig.view import versus_headline

        return versus_headline(self._result.summary)

    def said(self) -> list[str]:
        """The difference of the errors with its interval."""
        from labrig.view import difference_words

        return [difference_words(self._result.summary)]

    def _shown(self) -> "list[DataFrame]":
        return [self.where.loc[self.where["better"].notna()].head(5)]

    def _pictures(self) -> "dict[str, Callable[[], Figure]]":
        from labrig.view import versus_pictures

        return versus_pictures(self._result)

    def _write_report(self, folder: Path) -> Path:
        from labrig.view import write_versus

        return write_versus(self._result, folder)


@overload
def compare(runs: Any, model: "Sequence[Model | str | Path | Callable[..., Any]]") -> ModelComparison: ...
@overload
def compare(runs: Any, model: "Model | str | Path | Callable[..., Any]") -> Comparison: ...
def compare(runs: Any, model: Any) -> Comparison | ModelComparison:
    """Errors of a model as it stands, without any fit of effects: how large, and where. Of two models: which is nearer.

    Args:
        runs: one run or a list, as paths or as `labrig.open_run` gives them; of one rig.
        model: a model.yaml's path, what `labrig.Model.load` gives, or a function as `labrig.Model.of` takes it; or a
            list of two, to compare them.

    Returns:
        a `Comparison`; of two models a `ModelComparison`, which has the difference of their errors with its interval.

    Raises:
        LabrigError: a run or a model cannot be read, they do not fit together, or there are more than two models.

    Examples:
        >>> found = labrig.compare("runs/first", "model.yaml")
        >>> found.error["model"] > found.error["floor"]
        True
        >>> both = labrig.compare("runs/later", ["model.yaml", "improved.yaml"])
        >>> both.better
        'improved'
    """
    from labrig import diagnosis

    if not isinstance(model, list | tuple):
        return Comparison(diagnosis.compare(runs_of(runs), model_of(model)))
    if len(model) == 1:
        raise LabrigError("compare: a list of one model was given; give the model itself, or a list of two")
    if len(model) != 2:
        raise LabrigError(f"compare: {len(model)} models were given; it takes one model, or a list of two")
    first, second = map(model_of, model)
    return ModelComparison(diagnosis.versus(runs_of(runs), first, second))
