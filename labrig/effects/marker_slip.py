"""Marker slip: a marker moves on the surface, at one moment, or a few markers, each at its own."""

from collections.abc import Collection, Iterator

import numpy as np
from scipy.ndimage import median_filter

from labrig.arrays import Bools, Floats
from labrig.effects._context import Context
from labrig.effects._effect import Effect, Parameter, Term, Variant
from labrig.effects._family import Feature, Space, field, motion_scale
from labrig.effects._rows import capture_means
from labrig.effects._sign import Part, Sign, by_capture
from labrig.effects._slips import errors_by_capture, gain_of_cuts, moment, slips

_ALONG = 5
"""Captures that a running median takes before the step is sought: mistaken positions pass, a slip stays."""
_FORMS = ("step", "two steps", "three steps")
"""Forms by how many markers slipped, each once; more of them, or one that slips again, is the family's."""
_FEWEST = 2
"""Markers from which on one that slipped is another thing than a camera that was moved."""
_SLOW = 7
"""Slow motions over the run, cosines, that a loose marker may make beside its steps: a grid."""
_OF_WHICH = ("", ", of a second marker", ", of a third one")
_WHICH = (
    ("marker", "1", 0.0, "which marker, counted from 0"),
    ("since_s", "s", -np.inf, "when it slipped, since the run began"),
    ("since", "1", 0.0, "first capture after it, where times are unknown"),
)


def _nth(name: str, n: int) -> str:
    """What a parameter is called for the n-th marker: `marker`, `since_s`, then `marker_2`, `since_2_s`."""
    return name if n == 0 else f"{name.removesuffix('_s')}_{n + 1}" + "_s" * name.endswith("_s")


class MarkerSlip(Effect):
    name = "marker_slip"
    meaning = (
        "A marker was knocked or peeled off and now sits somewhere else: from one capture on\n"
        "it alone is off by a constant amount."
    )
    acts_on = "observation"
    remembers = True
    parameters = (
        Parameter("slip", "place", per="marker", meaning="where the marker went, along x, y, z"),
        *(
            Parameter(_nth(name, n), unit, low, meaning=meaning + _OF_WHICH[n], given=True)
            for n in range(len(_FORMS))
            for name, unit, low, meaning in _WHICH
        ),
    )
    reference = (
        "E. S. Page, Continuous inspection schemes, Biometrika 41 (1954) 100-115 (the change is found so)"
    )
    signature = "one marker's error steps at one capture and stays; its neighbours see nothing"
    experiment = "look at the marker; repeat one early capture"
    needs = "two markers or more"
    by_hand = "look at the marker, and press it on again"
    of_one_rig = "it says which marker slipped and when"
    scans = True

    def variants(self, context: Context) -> Iterator[Variant]:
        timed = bool(np.isfinite(context.rows.time_s).all())
        yield from self._step(context, timed)
        if timed and context.saved and "since" in context.pinned:  # fitted to a run without times
            yield from self._step(context, timed=False)

    def _step(self, context: Context, timed: bool) -> Iterator[Variant]:
        rows, when = context.rows, "since_s" if timed else "since"
        if context.saved or context.grid("marker", ()):
            pinned = context.pinned
            saved = [n for n in range(len(_FORMS)) if n == 0 or _nth("marker", n) in pinned]
            forms = [[(pinned.get(_nth("marker", n), 0.0), pinned.get(_nth(when, n), 0.0)) for n in saved]]
        else:
            found = [
                (float(m), moment(rows, c) if timed else float(c))
                for m, c in self.find(context)[: len(_FORMS)]
            ]
            forms = [found[: n + 1] for n in range(len(found))]
        for slipped in filter(None, forms):
            change = np.zeros((*context.base.shape, 0))
            labels: tuple[str, ...] = ()
            for marker, since in slipped:
                after = context.run_time_s >= since if timed else rows.capture >= since
                own = np.flatnonzero(rows.marker == marker)
                one = np.zeros((*context.base.shape, len(own)))
                one[np.ix_(after, own)] = np.eye(len(own))
                change = np.concatenate([change, one], axis=2)
                labels += tuple(rows.observables[k] for k in own)
            shape = {
                _nth(name, n): value
                for n, each in enumerate(slipped)
                for name, value in zip(("marker", when), each, strict=True)
            }
            form = _FORMS[len(slipped) - 1] + ("" if timed else " at a capture")
            yield Variant(form, (Term.field("slip", change, labels),), shape)

    @staticmethod
    def find(context: Context) -> list[tuple[int, int]]:
        """Markers and the capture of the clearest step of each, the clearest first; none with too few captures."""
        rows = context.rows
        error, captures = capture_means(context.residual, rows.capture)
        markers = np.unique(rows.marker[rows.marker >= 0])
        if len(captures) < 8 or len(markers) < _FEWEST:
            return []
        for a in range(3):
            own = rows.axis == a
            if own.sum() > 2:
                error[:, own] -= _median(error[:, own])[:, None]
        out = []
        for m in markers:
            e = error[:, rows.marker == m]
            seen = np.isfinite(e).all(axis=1)
            if seen.sum() < 8:
                continue
            at, noise = captures[seen], np.median(np.sum(np.diff(e[seen], axis=0) ** 2, axis=1)) + 1e-12
            gain = gain_of_cuts(median_filter(e[seen], size=(_ALONG, 1), mode="mirror"))
            gain[:3] = gain[-3:] = 0.0
            i = int(np.argmax(gain))
            if gain[i] > 0:
                out.append((float(gain[i] / noise), int(m), int(at[i + 1])))
        return [(m, at) for _, m, at in sorted(out, key=lambda one: -one[0])]

    def family(self, context: Context) -> Iterator[Space]:
        """A step of one marker at one moment: the three clearest steps that a scan over markers and moments finds."""
        rows = context.rows
        if len(np.unique(rows.capture)) < 8 or len(np.unique(rows.marker[rows.marker >= 0])) < _FEWEST:
            return
        captures, error = errors_by_capture(context)
        for slip in slips(rows, error):
            group, since = slip.group, int(captures[slip.first])
            own, after = np.isin(rows.marker, group), rows.capture >= since
            ramp = np.clip((rows.capture - since) / max(captures[-1] - since, 1), 0, None)
            moved = np.abs(np.diff(context.displacement[:, own], axis=0)).sum(axis=1)
            worn = np.append(0.0, np.cumsum(moved)) * after
            worn = np.maximum(worn - worn[after].min(initial=np.inf), 0) / max(np.ptp(worn[after]), 1e-9)
            ways = [("step", after.astype(float), 1.0), ("slide", ramp, 0.3), ("worn", worn, 0.3)]
            ways += [
                (f"step again {n}", (rows.capture >= captures[again]).astype(float), 0.3)
                for n, again in enumerate(slip.again)
            ]
            who = f"marker {group[0]}" if len(group) == 1 else f"markers {list(group)}"
            yield Space(
                f"{who} since {since}",
                "marker_slip",
                _of_each(context, own, ways if len(group) == 1 else ways[:2]),
                scanned=slip.among,
            )
            if len(group) == 1:
                along = (rows.capture - captures[0]) / max(np.ptp(captures), 1)
                slow = [(f"slow {n}", np.cos(np.pi * n * along), 1 / n) for n in range(1, _SLOW)]
                loose = [*_of_each(context, own, [*ways, *slow]), *_follows(context, own, after)]
                yield Space(f"{who} loose since {since}", "marker_slip", tuple(loose), scanned=slip.among)

    def covariate(self, context: Context) -> tuple[str, str, Floats]:
        return ("capture", "1", context.rows.capture.astype(float))

    def sign(self, context: Context, part: Part) -> Sign:
        """The marker's error along the way that it slipped, and that of the others along it, capture by capture."""
        rows, one = context.rows, by_capture(context, part)
        slipped = int(part.shape.get("marker", 0))
        way = np.zeros(3)
        mine = np.flatnonzero(rows.marker == slipped)
        way[rows.axis[mine]] = one.change[:, mine].sum(axis=0)
        way /= np.linalg.norm(way) or 1.0
        captures = np.unique(rows.capture).astype(float)
        x, y, f, group = [], [], [], []
        for m in np.unique(rows.marker[rows.marker >= 0]):
            own = np.flatnonzero(rows.marker == m)
            known = np.isfinite(one.left[:, own]).all(axis=1)
            x.append(captures[known])
            y.append((one.seen[:, own] @ way[rows.axis[own]])[known])
            f.append((one.change[:, own] @ way[rows.axis[own]])[known])
            group += [rows.markers[m] if m == slipped else "the other markers"] * int(known.sum())
        x, y, f = (np.concatenate(each) for each in (x, y, f))
        unit = rows.unit[int(mine[0])]
        return Sign("capture", "1", "error along the slip", unit, x, y, f, np.ones(len(x)), np.array(group))

    def lacks(self, context: Context, form: str, parameters: Collection[str]) -> str:
        missing = "since_s" in parameters and not np.isfinite(context.rows.time_s).all()
        return "the moments of its rows" if missing else ""


def _of_each(context: Context, own: Bools, ways: list[tuple[str, Floats, float]]) -> tuple[Feature, ...]:
    """Each of some observables by itself in some ways in time (F,), with their weights."""
    rows, scale, out = context.rows, motion_scale(context), []
    for k in np.flatnonzero(own):
        one = np.zeros(context.base.shape[1])
        one[k] = scale[k]
        out += [field(f"{way} {rows.marker[k]} {rows.axis[k]}", q[:, None] * one, w) for way, q, w in ways]
    return tuple(out)


def _follows(context: Context, own: Bools, after: Bools) -> tuple[Feature, ...]:
    """A loose marker follows what is under it in part only, since it slipped."""
    part = np.where(own, -context.displacement * after[:, None], 0.0)
    return (field("follows in part", part),)


def _median(x: Floats) -> Floats:
    out = np.zeros(len(x))
    some = np.isfinite(x).any(axis=1)
    out[some] = np.nanmedian(x[some], axis=1)
    return out
