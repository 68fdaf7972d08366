"""Effects that runs have nothing to be seen by."""

from tests.naming import verdict_of


def test_what_a_force_at_one_moment_of_each_hold_cannot_show(make_lab) -> None:
    """One chamber, a force, one row a set-point: no pairs, no places, no change along a hold."""
    lab = make_lab(captures=60, force=True, chambers=1, rows_s=(6.0,))
    said = verdict_of(lab.dataset(lab.predict(lab.u) + lab.noise()), lab.model()).considered
    unseen = {c.effect for c in said if not c.seen}
    assert unseen == {"coupling", "frame", "gravity", "leak", "marker_slip"}


def test_what_many_markers_along_long_holds_show(make_lab) -> None:
    """Three chambers, twelve markers, rows from 1.6 to 40 s: nothing is left unseen."""
    lab = make_lab(captures=40, markers=12, rows_s=(1.6, 3.0, 10.0, 40.0))
    said = verdict_of(lab.dataset(lab.predict(lab.u) + lab.noise()), lab.model()).considered
    assert all(c.seen for c in said)
