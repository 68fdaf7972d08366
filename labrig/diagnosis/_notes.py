"""What is said beside a verdict: of the run, of the noise, and of what the name is worth here."""

from collections.abc import Mapping, Sequence

import numpy as np

from labrig._linalg import rms
from labrig._text import listed, word
from labrig._turns import NO_UNIT, quaternions
from labrig.contents import Ranked
from labrig.diagnosis import _constants as k
from labrig.diagnosis._amount import amount
from labrig.diagnosis._begun_early import begun_early
from labrig.diagnosis._candidates import Fit
from labrig.diagnosis._falls import Fall
from labrig.diagnosis._floor import UNREPEATED
from labrig.diagnosis._observations import Observations
from labrig.diagnosis._one_speed import (
    counted_time,
    one_moment,
    one_side,
    one_speed,
    one_stroke,
    short_holds,
)
from labrig.diagnosis._problem import Prepared
from labrig.diagnosis._units_off import units_off
from labrig.diagnosis._verdict import Verdict
from labrig.effects import Effect, times_changed
from labrig.model import Model

_NAMED = 3
"""How many of them are named."""
NOTHING = "nothing that was recorded"
"""What carries what no space follows."""
_EARLY = 3.0
"""How many floors what was left out of each hold's beginning is off, for that to be said."""
_ALIKE = 0.5
"""From which part of what is left on repeats differ by as much: five pairs may be off by a factor of two."""
_MORE = 1.5
"""How many times the noise of a mean repeats differ by where they differ by more than that."""
MUCH_LESS = 0.7
"""Of an error: what something else leaves of it at most, for that to be said."""
_NEARLY = 0.9
"""Share of what can be explained that is nearly all of it."""
_SCATTERS = 5.0
"""How many times as noisy means are as rows within holds say, for that to be said where nothing was repeated."""


def notes_on(
    ready: Prepared,
    observations: Observations,
    verdict: Verdict,
    chosen: Fit | None,
    falls: Sequence[Fall],
    unit_size: float,
    effects: Mapping[str, Effect],
) -> list[str]:
    """What a person should know beside the verdict, a line each; `falls` are by how much what was found lowers the
    held-out error, `unit_size` is how large a floor is, in the units of the errors.
    """
    named = {name: effects[name] for name in (*verdict.effects, *verdict.rivals)}
    stroke = one_stroke(ready.context) if any("one stroke" in effects[n].blurred_by for n in named) else []
    return [
        *_warnings(ready, verdict),
        *_ruled_out(ready, verdict),
        *_said(observations, verdict, unit_size, ready.regression.units),
        *_unrepeated(ready, verdict, unit_size),
        *_doubted(chosen, verdict, falls),
        *(stroke or (one_speed(ready.context) if named else ())),
        *(short_holds(ready.context) if verdict.verdict != "nothing_missing" else ()),
        *counted_time(ready.context, named),
        *(_without_units(ready) if verdict.verdict != "nothing_missing" else ()),
        *(one_moment(ready.context) if any("one moment" in effects[n].blurred_by for n in named) else ()),
        *(one_side(ready.context) if any("one side" in effects[n].blurred_by for n in named) else ()),
    ]


def _without_units(ready: Prepared) -> list[str]:
    """A line on observables without a unit that are no quaternion: a stop is looked for where something moves."""
    rows = ready.context.rows
    turns = {k for own in quaternions(rows.unit, rows.values) for k in range(own.start, own.stop)}
    names = [name for k, name in enumerate(rows.observables) if rows.unit[k] in NO_UNIT and k not in turns]
    if not names:
        return []
    others = " and others" if len(names) > _NAMED else ""
    return [
        f"the unit of {listed(names[:_NAMED])}{others} is not known: where it is a length or an angle, say it in the "
        "mapping, since what stops a place or a joint is looked for among these alone"
    ]


def may_be_learnt(model: Model, verdict: Verdict, effects: Mapping[str, Effect]) -> list[str]:
    """A line where a model that may have been learnt is not said to be, and what is named is a curve of the set-points,
    as the error of such a model is.
    """
    names = [
        name
        for name in (*verdict.effects, *verdict.rivals)
        if effects[name].acts_on != "observation" and not effects[name].remembers
    ]
    base = model.file.base
    if not names or getattr(base, "learned", False) is not None or getattr(base, "heldout_error", None):
        return []
    return [
        f"if the model was fitted or trained on measurements, its own error may be what {listed(names, 'or')} "
        "explains: say learned: true in the model file, or learned: false of a formula"
    ]


def learnt_below(verdict: Verdict, base: float, floor: float, ceiling: float, unit: str) -> list[str]:
    """A line where nothing is said to be missing, and a learner predicts much of what was taken for noise (root mean
    squares of the held-out errors).
    """
    if verdict.verdict != "nothing_missing" or ceiling > MUCH_LESS * min(base, floor):
        return []
    return [
        f"a flexible learner predicts captures that were left out to {amount(ceiling, unit)}, where the model is off "
        f"by {amount(base, unit)} and the noise was taken to be {amount(floor, unit)}: repeats may differ by what "
        "drifted between them, or captures by what no effect follows, so repeat some set-points at once, too"
    ]


def nearly_explained(
    verdict: Verdict,
    ranking: Sequence[Ranked],
    base: float,
    model: float,
    floor: float,
    drop: float,
    unit: str,
) -> list[str]:
    """A line where the formula of an effect alone takes nearly all of the held-out error, down to the noise, and
    nothing is named, or what is named leaves more of it: the `drop` to what the `model` with that errs.
    """
    named = () if verdict.verdict == "unknown" else (*verdict.effects, *verdict.rivals)
    if verdict.verdict != "unknown" and (not named or drop >= _NEARLY):
        return []
    left = f", and what was named to {amount(model, unit)}" if named else ""
    return [
        f"the formula of {word(one['effect'])} alone would take the error from {amount(base, unit)} to "
        f"{amount(one['heldout_error'], unit)}{left}; evidence does not say that it is there, so it is not added: if "
        f"you know that it is, labrig improve --add {one['effect']}"
        for one in ranking[:1]
        if (one["drop"] or 0.0) >= _NEARLY
        and base**2 - one["heldout_error"] ** 2 >= _NEARLY * (base**2 - floor**2)
        and one["heldout_error"] < MUCH_LESS * base
        and one["effect"] not in named
    ]


def _scatters(ready: Prepared) -> list[str]:
    """A line where captures are off by much more than rows of one hold differ by, and nothing says whether that comes
    back with the set-point: what no effect follows was taken for noise.
    """
    counted, index = ready.regression.counted, np.unique(ready.context.rows.capture, return_inverse=True)[1]
    mean, within = (rms(noise[counted]) for noise in (ready.floor.mean, ready.floor.within))
    rows = float(np.median(np.bincount(index)))
    if rows < 2 or within <= 0 or mean < _SCATTERS * within / np.sqrt(rows):
        return []
    unit = ready.regression.units
    return [
        f"captures are off by {amount(mean, unit)}, each by another amount, where rows of one hold differ by "
        f"{within:.2g}: it counts as noise, and may as well be an error of each set-point (a regulator's steps, say); "
        "repeat some set-points, which tells"
    ]


def _ruled_out(ready: Prepared, verdict: Verdict) -> list[str]:
    """A line on each effect that looked possible and was ruled out in some captures: whether what looks like it is gone
    there.
    """
    out, rows = [], ready.context.rows
    for c in verdict.considered:
        count = sum(c.effect in own for own in rows.ruled_out)
        if not count or c.by_evidence < k.POSSIBLE:
            continue
        if c.gone >= k.SURE:
            says = "what looks like it is gone there"
            if times_changed(rows, c.effect) == 1:
                says += "; something else may have changed with it, so measure once more as it was"
        elif c.gone <= 1 - k.SURE:
            says = "what looks like it stays there, so it is something else"
        else:
            says = (
                "these can't tell whether what looks like it is gone: take all of it away, and measure set-points that "
                "show it (labrig next)"
            )
        captures = "1 capture" if count == 1 else f"{count} captures"
        out.append(f"{c.effect} was ruled out in {captures}, and {says}")
    return out


def _said(observations: Observations, verdict: Verdict, unit_size: float, unit: str) -> list[str]:
    """What cannot be seen beside effects that are many floors large, and what is there beside more without a name."""
    out = [
        f"{name} fits a part of it ({amount(size * unit_size, unit)}), but more than that has no name"
        for name, size in verdict.within.items()
    ]
    least = k.INEXACT * observations.to_explain
    if verdict.found and least >= 1:
        out.append(
            f"beside {' and '.join(verdict.found)}, nothing that is smaller than about "
            f"{amount(least * unit_size, unit)} can be seen: add it to the model, then diagnose that one on the same "
            "run"
        )
    return out


def _unrepeated(ready: Prepared, verdict: Verdict, unit_size: float) -> list[str]:
    """A line where repeats with the same history differ by as much as what follows nothing that was recorded."""
    left = verdict.beside.get(NOTHING, 0.0) * unit_size
    differ = ready.repeats["same history"]
    noise = rms(ready.floor.mean[ready.regression.counted])
    if (
        verdict.verdict != "unknown"
        or not left
        or differ is None
        or differ < max(_ALIKE * left, _MORE * noise)
    ):
        return []
    unit = ready.regression.units
    return [
        f"captures of one set-point with the same history differ by {amount(differ, unit)}, too: what follows nothing "
        "that was recorded does not repeat, so look at what trembles (frame, supply, mount) before the physics"
    ]


def _doubted(chosen: Fit | None, verdict: Verdict, falls: Sequence[Fall]) -> list[str]:
    """Effects that were found by the evidence, without a formula, or with one that helps no more than chance where it
    was not fitted.
    """
    able = {*(chosen.names if chosen else ()), *(fall.effect for fall in falls)}
    without = [
        f"no formula of {name} can act on these runs: it is named, and nothing is added to the model for it"
        for name in verdict.found
        if name not in able
    ]
    return without + [
        f"with {fall.effect} added, the held-out error falls no more than by chance ({fall.words}): captures that were "
        "left out bear out no formula of it, so it is not sure, and nothing is added for it"
        for fall in falls
        if not fall.helps
    ]


def _warnings(ready: Prepared, verdict: Verdict) -> list[str]:
    """What is to be known of the run, its noise, and what was left out."""
    rows = ready.context.rows
    out = [*rows.warnings, *units_off(ready.context)]
    if verdict.verdict != "nothing_missing":
        out += begun_early(ready.context, ready.floor.within)
    out += verdict.warnings
    if ready.repeats["same history"] is None:
        scatters = _scatters(ready) if verdict.verdict == "nothing_missing" else []
        out += scatters or [UNREPEATED]
    if len(rows.sessions) > 1 and rows.between_sessions == "unknown":
        out.append(
            "what the pressures did between sessions is unknown: taken as vented; `between_sessions:` in the mapping "
            "says it (vented, held)"
        )
    counted = ready.regression.counted
    early = rms(rows.early[counted])
    if verdict.verdict == "nothing_missing" and early > _EARLY * ready.quoted_floor:
        out.append(
            f"in the first second after an actuation, which is left out (valves, inertia), what is measured is still "
            f"{amount(early, rows.unit[int(counted[0])])} from where it settles: a lag so short is not looked at"
        )
    if len(moved := np.flatnonzero(ready.floor.shakes)):
        size = rms(ready.floor.shakes[moved])
        out.append(
            f"all markers move together from capture to capture, by {amount(size, rows.unit[int(moved[0])])}, "
            "and nothing that was recorded says why: it counts as noise, so look at the mounts of rig and cameras"
        )
    return [*out, *ready.left_out, *ready.not_quoted, *ready.within_only]
