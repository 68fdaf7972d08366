"""diagnose: what a model lacks, or that nothing is missing, or that it cannot be told."""

from typing import TYPE_CHECKING, Any, ClassVar

from labrig.api._answer import ModelAnswer
from labrig.api._inputs import model_of, runs_of
from labrig.contents import Summary

if TYPE_CHECKING:
    from pandas import DataFrame
    from xarray import Dataset

    from labrig.model import Model


class Diagnosis(ModelAnswer):
    """What is missing from a model.

    `verdict` is nothing_missing, identified, multiple, confounded, unknown or underpowered; `effects` has a row for
    each effect of the library; `improved` is the model with what is sure, if anything is. In `error` and `fields`
    `base` is the model that was given, and `model` is it with what was found.
    """

    name: ClassVar[str] = "diagnosis"

    @property
    def verdict(self) -> str:
        """nothing_missing, identified, multiple, confounded, unknown or underpowered."""
        return str(self.summary["verdict"])

    @property
    def probability(self) -> float:
        """How probable all of what the verdict says is, 0 to 1: that what it names is there, and that nothing else is.

        So it is less than an effect's own probability (`effects`), which says nothing of the others.
        """
        return float(self.summary["probability"])

    @property
    def sure(self) -> list[str]:
        """The names of the effects that are sure."""
        return list(self.summary["effects"])

    @property
    def possible(self) -> list[str]:
        """The names of those that may be there, or not, the most probable first."""
        return [row["effect"] for row in self.summary["effects_considered"] if row["call"] == "possible"]

    @property
    def effects(self) -> "DataFrame":
        """Every effect, the most probable first.

        Columns: `effect`, `call` (sure, possible, not it), `probability`, `size` and `size_sd` in `units`,
        `size_floors` and `size_sd_floors` in times the noise of a capture's mean.
        """
        return effects_table(self._result.summary)

    @property
    def improved(self) -> "Model | None":
        """The model with what is sure and the likeliest of what is only possible; None where nothing has a name."""
        return self._result.improved

    def said(self) -> list[str]:
        """What is sure and what is possible, each with its probability."""
        from labrig.view import summary_words

        return [summary_words(self._result.summary).found]

    def _shown(self) -> "list[DataFrame]":
        return [self.effects.query("probability >= 0.1"), *super()._shown()]


def effects_table(summary: Summary) -> "DataFrame":
    """Every effect that a diagnosis (the content of diagnosis.json) considered, the most probable first."""
    from pandas import DataFrame

    columns = ["effect", "call", "probability", "size", "size_sd", "size_floors", "size_sd_floors"]
    table = DataFrame(summary.get("effects_considered", []), columns=columns)
    return table.sort_values("probability", ascending=False, ignore_index=True)


def diagnose(runs: Any, model: Any, *, tolerance: float | None = None, without: Any = ()) -> Diagnosis:
    """Compare a model with measurements and say what is missing from it.

    Args:
        runs: one run or a list, as paths or as `labrig.open_run` gives them; of one rig.
        model: a model.yaml's path, what `labrig.Model.load` gives, or a function as `labrig.Model.of` takes it.
        tolerance: the smallest effect that matters, in the units of the observables.
        without: names of effects to leave out of the library.

    Raises:
        LabrigError: a run or the model cannot be read, or they do not fit together.

    Examples:
        >>> found = labrig.diagnose("runs/first", "model.yaml")
        >>> found.verdict
        'identified'
        >>> found.effects["effect"][0]
        'hysteresis'
    """
    from labrig import diagnosis, experiment
    from labrig.api._inputs import names_of, positive

    if tolerance is not None:
        positive(tolerance, "tolerance", "in the units of the observables")
    left_out = names_of(without, "an effect to leave out") if without else []
    opened, questioned = runs_of(runs), model_of(model)
    result = diagnosis.diagnose(opened, questioned, tolerance=tolerance, without=left_out)
    result.summary["warnings"] += _of_before(opened, result.summary)
    experiment.plan_next(opened, questioned, result.summary)
    return Diagnosis(result)


def _of_before(runs: "list[Dataset]", summary: Summary) -> list[str]:
    """A line where something is missing, and the rig was in use shortly before these runs."""
    from labrig.catalogue import used_before

    if summary["verdict"] == "nothing_missing" or (before := used_before(runs)) is None:
        return []
    name = before.folder.name
    return [
        f"the rig was in use until {before.gap_s / 60:.0f} min before ({name}), which it may remember: what creeps or "
        f"has a loop looks like something else then, so diagnose {name} with it"
    ]
