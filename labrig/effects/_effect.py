"""The small class that every physical effect is, and the terms by which it changes a prediction."""

from abc import ABC, abstractmethod
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from typing import ClassVar, Literal

import numpy as np

from labrig.arrays import Floats
from labrig.effects._context import Context
from labrig.effects._family import Space
from labrig.effects._fitted import Fitted
from labrig.effects._sign import Part, Sign, along_own

Acts = Literal["pressure", "mechanics", "observation"]
Kind = Literal["pressure", "pattern", "frame", "field"]
Blurs = Literal["one moment", "one side", "one speed", "one stroke"]


@dataclass(frozen=True)
class Parameter:
    """One physical quantity of an effect: its unit, its bounds, and whether each chamber has its own.

    `least`: what it is at least where the effect acts at all. A fitted value far below is another law's misfit.
    One for each session is saved by the session's name, and is nothing in sessions that it was not fitted to.
    `given`: it is read off the run and saved, not fitted. `turns`: where a displacement is commanded and a force
    measured, its bounds change their signs (what yields under a load relaxes under a stretch). A unit may have
    "actuation", "observable", "place" (of a marker), "sensor" (of what is no marker's) or "motion" (of a logged
    position) in it, which stand for the run's.
    """

    name: str
    unit: str
    low: float = -np.inf
    high: float = np.inf
    per: Literal["one", "chamber", "marker", "session"] = "one"
    meaning: str = ""
    least: float = 0.0
    given: bool = False
    turns: bool = False

    def bounds(self, context: Context) -> tuple[float, float]:
        """The lowest and the highest value that are physical on these measurements."""
        return (-self.high, -self.low) if self.turns and context.stretched else (self.low, self.high)


WEIGHTS = Parameter("weights", "1", meaning="of the functions of the effect's family")
"""What an effect has in place of a formula's parameters where no formula is good enough."""


@dataclass(frozen=True)
class Term:
    """Columns that an effect adds, each multiplied by one unknown coefficient.

    `kind` says where `feature` acts, for F rows, K observables, C chambers and q columns:

    - `pressure`: (F, C, q), an equivalent change of the actuation, carried to the observables by the
      base model's Jacobian;
    - `pattern`: (F, q), a change whose shape over the observables is free;
    - `frame`: (F,), a rigid motion of the measuring frame (three translations, three small rotations);
    - `field`: (F, K, q), a change of the observables themselves.
    """

    parameter: str
    kind: Kind
    feature: Floats
    labels: tuple[str, ...] = ()
    basis: Floats | None = field(default=None, repr=False)
    """What is saved, (labels, q): the values of the labels are this times the coefficients, which are equally likely
    beforehand; else they are the coefficients, and these are free."""

    @classmethod
    def common(cls, parameter: str, change: Floats) -> "Term":
        """One coefficient for all chambers; `change` (F, C), units of the actuation."""
        _check("common", parameter, change, "(rows, chambers)", 2)
        return cls(parameter, "pressure", change[:, :, None])

    @classmethod
    def per_chamber(cls, parameter: str, change: Floats, chambers: tuple[str, ...]) -> "Term":
        """A coefficient for each chamber; `change` (F, C), units of the actuation."""
        _check("per_chamber", parameter, change, "(rows, chambers)", 2)
        F, C = change.shape
        if len(chambers) != C:
            raise ValueError(
                f"Term.per_chamber({parameter!r}): {C} columns, where the {len(chambers)} chambers have one each"
            )
        feature = np.zeros((F, C, C))
        feature[:, range(C), range(C)] = change
        return cls(parameter, "pressure", feature, chambers)

    @classmethod
    def pattern(cls, parameter: str, feature: Floats, labels: tuple[str, ...] = ()) -> "Term":
        """A free pattern over the observables for each column of `feature` (F,) or (F, q)."""
        _check("pattern", parameter, feature, "(rows,) or (rows, columns)", 1, 2)
        return cls(parameter, "pattern", feature.reshape(len(feature), -1), labels)

    @classmethod
    def field(cls, parameter: str, change: Floats, labels: tuple[str, ...] = ()) -> "Term":
        """A change of the observables themselves, (F, K) or (F, K, q)."""
        _check("field", parameter, change, "(rows, observables) or (rows, observables, columns)", 2, 3)
        return cls(parameter, "field", change if change.ndim == 3 else change[:, :, None], labels)


def _check(kind: str, parameter: str, given: Floats, wanted: str, *dimensions: int) -> None:
    """Raise `ValueError`, which names the term, for columns of so many dimensions that they are none."""
    shape = getattr(given, "shape", None)
    if shape is None or len(shape) not in dimensions:
        what = f"shape {shape}" if shape is not None else f"a {type(given).__name__}"
        raise ValueError(f"Term.{kind}({parameter!r}): {what} was given, where {wanted} is needed")


@dataclass(frozen=True)
class Variant:
    """One form that an effect may take: its terms, and the values of what is not linear in it.

    `centred`: its values refer to the middle of the markers at rest, which is saved with them. `units`: of parameters
    that are about one sensor, whose own unit they have.
    """

    form: str
    terms: tuple[Term, ...]
    shape: dict[str, float] = field(default_factory=dict)
    centred: bool = False
    units: dict[str, str] = field(default_factory=dict)

    @property
    def key(self) -> str:
        """A name that is unique within the effect, such as ``log-time tau_s=3``."""
        return " ".join([self.form, *(f"{name}={value:g}" for name, value in self.shape.items())])


class Effect(ABC):
    """A named physical cause that changes a prediction.

    A new effect is a subclass in a file of its own: the class attributes say what it is, and `variants`
    yields the forms it may take on the campaign at hand (none where it can't act, or can't be seen).
    """

    name: ClassVar[str]
    meaning: ClassVar[str]
    acts_on: ClassVar[Acts]
    parameters: ClassVar[tuple[Parameter, ...]]
    reference: ClassVar[str]
    signature: ClassVar[str]
    experiment: ClassVar[str]
    needs: ClassVar[str] = ""
    """What a run must have for this effect to show, if not every run has it: `two markers or more`."""
    scans: ClassVar[bool] = False
    """Whether its forms are found by looking at the residuals, so that it must look again when they change."""
    remembers: ClassVar[bool] = False
    """Whether what it does depends on time, or on what was before: a curve of the set-points alone is not it."""
    blurred_by: ClassVar[frozenset[Blurs]] = frozenset()
    """What makes it look like the other effects that say the same: set-points that are all seen at `one moment` after
    they were set or approached from `one side`, inputs that always move at `one speed`, or in `one stroke` there and
    back."""
    by_hand: ClassVar[str] = ""
    """What a person can do that shows it and no programme can do alone: offered, never run unattended."""
    then_measured: ClassVar[bool] = False
    """Whether set-points are measured once that was done."""
    ruled_out_by: ClassVar[str] = ""
    """What a person does so that it cannot act while set-points are measured again; empty where nobody can."""
    unit_in_names: ClassVar[str] = ""
    """The unit of the numbers in the names of its family's functions: `s`, or `%` where they are shares."""
    of_one_rig: ClassVar[str] = ""
    """Why its values mean nothing on another rig, where they do not: `it says which marker slipped and when`."""

    @abstractmethod
    def variants(self, context: Context) -> Iterator[Variant]:
        """Yield the forms that this effect may take on `context`, the simplest first."""

    def family(self, context: Context) -> Iterator[Space]:
        """Yield the spaces of functions that the laws of this effect span: its forms, unless it says more."""
        from labrig.effects._forms import spaces_of

        yield from spaces_of(self, context)

    def covariate(self, context: Context) -> tuple[str, str, Floats]:
        """The covariate that its signature is plotted against: name, unit, values (F,)."""
        return ("load", "1", context.rows.fraction.mean(axis=1))

    def follows(self, context: Context) -> Collection[str]:
        """The covariates that were logged because of this effect: what follows one of them, in any way, is it."""
        return ()

    def turned_round(self, context: Context) -> str:
        """What carries the residual where that is this effect the other way round, which it cannot be; else empty."""
        return ""

    def sign(self, context: Context, part: Part) -> Sign:
        """Its signature as the points of a plot: its own pattern against its covariate, unless it overrides this."""
        name, unit, x = self.covariate(context)
        return along_own(context, part, x, name, unit)

    def carried(self, context: Context, form: str, values: Mapping[str, float]) -> Context:
        """The context that effects after this one see; the same, unless it turns all that the model says of motions."""
        return context

    def lacks(self, context: Context, form: str, parameters: Collection[str]) -> str:
        """What a saved form needs and `context` has not, in words; empty where nothing is lacking. `parameters` are the
        names of its parameters, of a family those of its functions.
        """
        return ""

    def in_words(self, found: Fitted) -> str:
        """What its fitted values come to, in a sentence; empty where they speak for themselves."""
        return ""

    @classmethod
    def parameter(cls, name: str) -> Parameter:
        """Look a parameter up by name."""
        return next(p for p in (*cls.parameters, WEIGHTS) if p.name == name)
