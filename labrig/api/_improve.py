"""improve: effects added to a model, fitted and judged."""

from dataclasses import replace
from datetime import UTC, datetime
from math import isfinite
from typing import TYPE_CHECKING, Any, ClassVar

from labrig._errors import LabrigError
from labrig.api._answer import ModelAnswer
from labrig.api._inputs import model_of, names_of, runs_of

if TYPE_CHECKING:
    from pandas import DataFrame
    from xarray import Dataset

    from labrig.diagnosis import Result
    from labrig.model import Model


class Improvement(ModelAnswer):
    """A model with effects added: `error["base"]` before, `error["model"]` after, on held-out captures."""

    name: ClassVar[str] = "improve"

    @property
    def added(self) -> list[str]:
        """The names of the effects that were added."""
        return list(self.summary["effects"])

    @property
    def drop(self) -> float:
        """The share of what could be explained that the effects explain: 1 is all of it, below 0 they make it worse."""
        return float(self.summary["drop"])

    @property
    def model(self) -> "Model":
        """The new model; `model.save("improved.yaml")` writes it."""
        assert self._result.improved is not None
        return self._result.improved

    @property
    def prior(self) -> "DataFrame":
        """Where effects were carried over: every value, with its standard deviation; empty without a prior.

        As the `prior` has it, the runs (`data`), and both together (`value`).
        """
        from pandas import DataFrame

        columns = ["prior", "prior_sd", "data", "data_sd", "value", "sd"]
        told = self.summary.get("prior")
        return DataFrame({name: told[name] if told else [] for name in columns})


def improve(
    runs: Any, model: Any, add: Any, *, force: bool = False, prior: Any = None, spread: float | None = None
) -> Improvement:
    """Fit effects together and add them to a model; with a prior, carry them over from where they were fitted before.

    Args:
        runs: one run or a list, as paths or as `labrig.open_run` gives them; of one rig.
        model: a model.yaml's path, what `labrig.Model.load` gives, or a function as `labrig.Model.of` takes it.
        add: the name of an effect, or several.
        force: add them even if they do not lower the held-out error.
        prior: models that have the effects already, fitted on another rig or day: one or a list, as `model`. Their
            values, pooled, are combined with what these runs say, each weighted by how sure it is.
        spread: how much an effect may differ from place to place, as a share of it; 0.3 if left out. From three priors
            on, they say it themselves.

    Raises:
        LabrigError: an effect does not exist, cannot act on these runs, is in the model already, or does not help; or
            the runs contradict the prior.

    Example:
        >>> better = labrig.improve("runs/first", "model.yaml", "hysteresis")
        >>> better.error["model"] < better.error["base"]
        True
        >>> better.model.save("improved.yaml")
    """
    names = names_of(add, "an effect to add")
    opened, known = runs_of(runs), model_of(model)
    for name in names:
        if all(_never_acts(name, run) for run in opened):
            raise LabrigError(
                f"{name} was ruled out in all of these captures: give a run in which it can act"
            )
    if prior is None:
        if spread is not None:
            raise LabrigError("a spread says how far a prior holds elsewhere: name one (prior=, --prior)")
        from labrig.diagnosis import improve

        return Improvement(_dated(improve(opened, known, names, force=force), opened, known))
    from labrig.passport import SPREAD, carry

    priors = [model_of(each) for each in (prior if isinstance(prior, list | tuple) else [prior])]
    if not priors:
        raise LabrigError("no prior was given: name a model.yaml that has the effect")
    share = SPREAD if spread is None else spread
    if not 0 <= share < 10:
        raise LabrigError(f"spread {share:g}: must be from 0 to 10, a share of the effect")
    return Improvement(_dated(carry(opened, known, names, priors, spread=share, force=force), opened, known))


def _never_acts(effect: str, run: "Dataset") -> bool:
    """Whether an effect was ruled out in all captures of a run."""
    from labrig.effects import ruled_out_in

    names = ruled_out_in(run)
    return bool(names) and all(effect in own for own in names)


def _dated(result: "Result", runs: "list[Dataset]", known: "Model") -> "Result":
    """The result whose new model says when the last run was recorded that it was fitted to, where the runs say that;
    `known` is the model that it goes on from.
    """
    ends = [float(run.attrs.get("start_s", "nan")) + float(run["time_s"].max()) for run in runs]
    if result.improved is None or not all(isfinite(end) for end in ends):
        return result
    until = datetime.fromtimestamp(max(ends), UTC).replace(microsecond=0)
    before = known.file.fitted_until
    if before is not None:  # the effects that it had already may have been fitted to later runs
        until = max(until, before if before.tzinfo else before.replace(tzinfo=UTC))
    file = result.improved.file.model_copy(update={"fitted_until": until})
    return replace(result, improved=replace(result.improved, file=file))
