"""A campaign with its open explanations, ready to be asked what programmes would tell about them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from labrig._errors import LabrigError
from labrig.arrays import Floats, Ints
from labrig.diagnosis import SURE, Explained, Outlook, Prepared, calibration
from labrig.effects import Context, Rows, join_rows
from labrig.experiment._information import information, log_bayes
from labrig.experiment._plan import Limits, Planned, Point, planned_rows
from labrig.experiment._rivals import Rival
from labrig.model import Predictor


@dataclass(frozen=True)
class Problem:
    """What was measured (`explained`, where something has a name), the model, what is open, and what the rig allows."""

    ready: Prepared
    predictor: Predictor
    limits: Limits
    explained: Explained | None = None
    rivals: tuple[Rival, ...] = ()

    @property
    def context(self) -> Context:
        """What was measured."""
        return self.ready.context

    @property
    def counted(self) -> Ints:
        """The observables that figures are quoted for."""
        return self.ready.regression.counted

    @property
    def floor(self) -> float:
        """The noise of these, root mean square, in their units."""
        floor = (self.ready if self.explained is None else self.explained.ready).floor
        return float(np.sqrt(np.mean(floor.row[self.counted] ** 2)))

    @property
    def unit_size(self) -> float:
        """How large a floor of what is expected is, in their units: see `Observations.unit_size`."""
        assert self.explained is not None
        return self.explained.observations.unit_size(self.counted)

    def joint(self, programmes: Sequence[Sequence[Point]]) -> tuple[Context, Planned]:
        """The run and, in one further session, the programmes, each from a vented rig on, as one campaign."""
        planned = planned_rows(self.context.rows, programmes, self.limits)
        return join_contexts(self.context, self.predictor.context(planned.rows)), planned

    def outlooks(self, programmes: Sequence[Sequence[Point]]) -> list[Outlook]:
        """What each form of each explanation expects of each programme."""
        assert self.explained is not None
        joint, planned = self.joint(programmes)
        declared, calibrated = self.predictor.declared(joint.rows), self.predictor.calibrated(joint.rows)
        forms = [form for rival in self.rivals for form in rival.forms]
        return self.explained.outlooks(joint, declared, calibrated, planned.owner, forms)

    @cached_property
    def _forms(self) -> tuple[Floats, Ints]:
        """Of each form its probability and the number of its explanation."""
        probability = np.concatenate([r.probability * r.weight for r in self.rivals])
        return probability, np.repeat(np.arange(len(self.rivals)), [len(r.forms) for r in self.rivals])

    def information(self, outlook: Outlook) -> float:
        """What numbers say about which explanation is true, nats."""
        return information(outlook, *self._forms)

    @cached_property
    def pairs(self) -> list[tuple[int, int]]:
        """Every ordered pair (true, other) in which the other one can fall behind: it has not all names of the true."""
        names = [set(r.names) for r in self.rivals]
        each = range(len(names))
        return [(m, n) for m in each for n in each if not names[m] <= names[n]]

    def log_bayes(self, outlook: Outlook) -> Floats:
        """The median logarithm of the Bayes factor of each pair, natural."""
        found = log_bayes(outlook, *self._forms)
        return np.array([found[pair] for pair in self.pairs])

    @cached_property
    def goals(self) -> Floats:
        """The logarithm of the Bayes factor that would make the true one of each pair sure against the other.

        Probabilities are stated with less of the odds than evidence gives: so much more of it is needed. What the odds
        between the two are already counts as it is stated, no more.
        """
        p = [r.probability for r in self.rivals]
        sure = np.log(SURE / (1 - SURE)) / calibration().odds
        return np.array([sure - np.log(p[m] / p[n]) for m, n in self.pairs])

    @cached_property
    def matters(self) -> Floats:
        """How much each pair matters, 1 on average: by the probability of the one and of the other."""
        p = np.array([self.rivals[m].probability * self.rivals[n].probability for m, n in self.pairs])
        return p / p.mean()


def join_contexts(run: Context, planned: Context) -> Context:
    """The run and what is planned as one campaign, as a diagnosis of both together will see them.

    All that is planned is one session, since some of it will be; each programme keeps its own history.
    """
    together = replace(
        planned.rows, session=np.zeros_like(planned.rows.session), sessions=("planned",), session_keys=()
    )
    rows = join_rows([run.rows, _as_the_run(together, run.rows)], remembers=False)
    rows = replace(rows, between_sessions=_between(run.rows))
    both = {
        name: np.concatenate([getattr(run, name), getattr(planned, name)])
        for name in ("base", "jacobian", "deflection", "event_deflection", "deflection_slope")
    }
    inside = {
        name: np.concatenate([change, planned.inside[name]])
        for name, change in run.inside.items()
        if name in planned.inside
    }
    displaced = np.concatenate([run.displacement, planned.displacement])
    return replace(run, rows=rows, inside=inside, displaced=displaced, _memo={}, **both)


def _as_the_run(planned: Rows, run: Rows) -> Rows:
    if planned.chambers != run.chambers:
        raise LabrigError("the programme's chambers are not those of the run")
    return planned


def _between(rows: Rows) -> str:
    return rows.between_sessions if rows.between_sessions == "held" else "vented"
