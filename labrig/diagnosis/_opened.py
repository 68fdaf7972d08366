"""Runs beside a model, prepared once: compared, and tried with effects, as often as somebody likes."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from typing import TYPE_CHECKING

import numpy as np

from labrig._errors import LabrigError
from labrig.contents import Errors, Place, Summary
from labrig.diagnosis._about import about
from labrig.diagnosis._by_unit import by_unit
from labrig.diagnosis._candidates import Candidate, Fit, error_of, fit, quoted
from labrig.diagnosis._falls import Fall, fall_of
from labrig.diagnosis._floor import UNREPEATED
from labrig.diagnosis._formula import fit_named, forms_of
from labrig.diagnosis._noise_scale import with_noise_of_few
from labrig.diagnosis._parameters import entries_of
from labrig.diagnosis._present import fields_of, signatures_of
from labrig.diagnosis._problem import Prepared, last_of, prepared, rows_from
from labrig.diagnosis._ranking import drop_of
from labrig.diagnosis._result import Result
from labrig.diagnosis._units_off import units_off
from labrig.diagnosis._where import where
from labrig.effects import Effect, get
from labrig.model import EffectEntry, Model

if TYPE_CHECKING:
    from xarray import Dataset


_MOST_FITS = 100
"""Fits that are kept for the next trial."""


@dataclass(frozen=True)
class Trial:
    """Effects added to a model: the result, what each is worth, and the fit itself."""

    result: Result
    falls: tuple[Fall, ...]
    fit: Fit


class Opened:
    """Runs of one rig beside a model: what they say of it, and of effects that are added to it.

    With `only_last` they say it of the last of several runs; the others are what it remembers. Raises `LabrigError`
    when the runs and the model do not fit together.
    """

    def __init__(self, runs: "Sequence[Dataset] | Dataset", model: Model, *, only_last: bool = False) -> None:
        self.model = model
        many = list(runs) if isinstance(runs, list | tuple) else [runs]
        ready = prepared(last_of(many) if only_last else rows_from(many), model)  # type: ignore[arg-type]
        self.ready = with_noise_of_few(ready, model.library())
        self.about = about(runs, model)
        self._forms: dict[str, list[Candidate]] = {}
        self._last: dict[str, Candidate] = {}
        self._fits: dict[frozenset[int], Fit] = {}

    @property
    def units(self) -> str:
        """Those that errors are quoted in."""
        return self.ready.regression.units

    @cached_property
    def places(self) -> list[Place]:
        """Where the model as it stands fails."""
        ready = self.ready.unfitted
        return where(ready.context, ready.residual, ready.floor, ready.regression.counted)

    def forms(self, effect: Effect) -> list[Candidate]:
        """The forms of an effect, best first; found once."""
        if effect.name not in self._forms:
            self._forms[effect.name] = forms_of(self.ready.regression, self.ready.context, effect)
        return self._forms[effect.name]

    def compare(self) -> Result:
        """Errors of the model as it stands, without any fit of effects: how large, and where."""
        ready = self.ready.unfitted
        regression = ready.regression
        error: Errors = {
            "model": error_of(regression, regression.residual),
            "floor": ready.quoted_floor,
        }
        summary: Summary = {
            "units": regression.units,
            "error": error,
            "error_by_unit": by_unit(regression, ready.floor, model=regression.residual),
            "where": self.places,
            "floor": ready.floor.told(regression.units),
            "warnings": [*_warnings(ready), *_fitted_anew(ready)],
            **self.about,
        }
        return Result(
            summary=summary,
            fields=fields_of(ready.context, ready.residual, None),
            waterfall=[("model", error["model"]), ("floor", error["floor"])],
            signatures=[],
            where=self.places,
        )

    def add(self, names: Sequence[str], *, refine: bool = True, beside: Trial | None = None) -> Trial:
        """Fit the named effects together and add them to the model, whether they help or not.

        Without `refine`, effects that were tried before keep the form that was found then, and times and widths stay
        on the grid that they are looked for on: quick, and nearly the same. `beside` a trial its effects keep the
        forms that they have there, and nothing is moved: so the fall is that from the error of this trial.

        Raises `LabrigError` when an effect does not exist, can't act on these runs, or is in the model already.
        """
        effects = [get(name, self.model.folder) for name in dict.fromkeys(names)]
        for effect in effects:
            if any(entry.name == effect.name for entry in self.model.file.effects):
                raise LabrigError(f"the model has {effect.name!r} already; remove its entry to fit it again")
        ready, regression, context = self.ready, self.ready.regression, self.ready.context
        start = None if refine else dict(self._last)
        if beside is not None:
            start = {part.effect.name: part for part in beside.fit.parts}
        chosen = fit_named(regression, context, effects, forms=self.forms, start=start)
        if beside is None:
            self._last |= {part.effect.name: part for part in chosen.parts}
        base = error_of(regression, regression.base_left)
        now = quoted(chosen)
        floor = ready.quoted_floor
        falls = tuple(fall_of(chosen, i, self._fit) for i in range(len(effects)))
        entries = entries_of(context, chosen)
        steps = [("base", base)]
        for i, effect in enumerate(effects):
            steps.append((f"+ {effect.name}", quoted(self._fit(chosen.parts[: i + 1]))))
        summary: Summary = {
            "units": self.units,
            "effects": [effect.name for effect in effects],
            "error": {"base": base, "model": now, "floor": floor},
            "error_by_unit": by_unit(
                regression,
                ready.floor,
                base=regression.base_left,
                model=chosen.left,
            ),
            "drop": drop_of(base, now, floor),
            "added": [entry.model_dump(exclude_none=True) for entry in entries],
            "where": self.places,
            "warnings": [*_warnings(ready), *ready.within_only, *_undated(entries)],
            **self.about,
        }
        result = Result(
            summary=summary,
            fields=fields_of(context, ready.residual, chosen),
            waterfall=[*steps, ("floor", floor)],
            signatures=signatures_of(
                context, ready.residual, ready.floor.row, dict.fromkeys(chosen.names, chosen)
            ),
            where=self.places,
            improved=reduce(Model.with_effect, entries, self.model),
        )
        return Trial(result, falls, chosen)

    def _fit(self, parts: Sequence[Candidate]) -> Fit:
        """Candidates fitted together, once; a fit holds its candidates, so that their identities stay theirs."""
        key = frozenset(map(id, parts))
        if key not in self._fits:
            self._fits[key] = fit(parts)
            for old in list(self._fits)[:-_MOST_FITS]:
                del self._fits[old]
        return self._fits[key]


def _warnings(ready: Prepared) -> list[str]:
    """What is to be known of the run, and what was left out."""
    unsure = [UNREPEATED] if ready.repeats["same history"] is None else []
    return [
        *ready.context.rows.warnings,
        *units_off(ready.context),
        *unsure,
        *ready.left_out,
        *ready.not_quoted,
    ]


def _fitted_anew(ready: Prepared) -> list[str]:
    """A line where what a base calls its own is fitted to the runs that it is compared with."""
    if ready.declared is None and ready.calibrated is None:
        return []
    return [
        "the base is fitted to this run anew, so this says how well such a base can follow it, and nothing of how well "
        "what was fitted elsewhere predicts it"
    ]


def _undated(entries: Sequence[EffectEntry]) -> list[str]:
    """A line for each effect that begins at a moment of a run of which nobody knows when it was measured."""
    out = []
    for entry in entries:
        since = entry.parameters.get("since_s")
        if since is not None and (entry.fitted_on is None or entry.fitted_on.start_s is None):
            minutes = float(np.ravel(since.value)[0]) / 60  # type: ignore[arg-type]
            out.append(
                f"{entry.name} begins {minutes:.3g} min after the start of this run, and nothing says when that was: "
                "on another run without dates it would begin as late. Import runs with their dates, or use the model "
                "without it once what moved was put right"
            )
    return out
