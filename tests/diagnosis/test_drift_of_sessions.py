"""A drift over several sessions: what begins anew each morning, and what goes on from day to day, are two laws."""

import numpy as np
import pytest

from labrig.diagnosis import prepared, rows_from
from labrig.effects import get
from tests.naming import verdict_of

WAY_MM = np.array([0.3, -0.5, 0.8] * 6) * np.linspace(1.0, 0.4, 18)


def settles(lab) -> np.ndarray:
    """A stand that sags again each morning, less and less (R. Kohlrausch 1854: a stretched exponential), (n, T, K)."""
    began = np.array([lab.event_s[lab.session == s].min() for s in range(lab.sessions)])
    own_s = lab.time_s - began[lab.session][:, None]
    return 0.9 * (1 - np.exp(-np.sqrt(own_s / 60.0)))[:, :, None] * WAY_MM


def dries(lab) -> np.ndarray:
    """A skin that dries out over all days, by the root of time (J. Crank 1956: diffusion, a half space), (n, T, K)."""
    return 1.5 * np.sqrt(lab.time_s / lab.time_s.max())[:, :, None] * WAY_MM


@pytest.mark.parametrize("law", [settles, dries])
def test_either_law_is_named(make_lab, law) -> None:
    """Neither is the less probable for the other, which the same effect might have been."""
    lab = make_lab(chambers=3, markers=6, captures=60, sessions=2)
    found = verdict_of(lab.dataset(lab.predict(lab.u) + law(lab) + lab.noise()), lab.model())
    assert (found.verdict, found.effects) == ("identified", ("drift",))


def keys(lab) -> set[str]:
    """How the spaces of drift are called on its campaign."""
    ready = prepared(rows_from(lab.dataset(lab.predict(lab.u) + lab.noise())), lab.model())
    return {space.key for space in get("drift").family(ready.context)}


def test_each_clock_has_spaces_of_its_own(make_lab) -> None:
    """Beside all functions what goes one way in each session, and a trend over all; of one session there is neither."""
    several = keys(make_lab(captures=20, sessions=2))
    assert {"pattern", "pattern, anew", "pattern, trend"} <= several
    assert not [key for key in keys(make_lab(captures=20)) if ", " in key]


def test_a_trend_turns_less_often_than_there_are_sessions(make_lab) -> None:
    """What may be another in each session is none: of five sessions two half waves, of two none."""
    for sessions, waves in ((2, 0), (5, 2)):
        lab = make_lab(captures=20, sessions=sessions)
        ready = prepared(rows_from(lab.dataset(lab.predict(lab.u) + lab.noise())), lab.model())
        of = {space.key: [f.name for f in space.features] for space in get("drift").family(ready.context)}
        assert sum("cosine" in name for name in of["pattern, trend"]) == waves
        assert not [name for name in of["pattern, trend"] if name.startswith("session")]
        assert not [name for name in of["pattern, anew"] if name.startswith("run") or "cosine" in name]
