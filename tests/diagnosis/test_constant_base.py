"""A base that says the same at all pressures, while the pressures change."""

from labrig.diagnosis import diagnose


def test_a_base_that_ignores_the_pressures_is_diagnosed(make_lab):
    """A newcomer's first model, a constant, gets a verdict; nothing is divided by how far it moves."""
    lab = make_lab(captures=30)
    run = lab.dataset(lab.predict(lab.u) + lab.noise())
    lab.reach = 0 * lab.reach
    summary = diagnose(run, lab.model()).summary
    assert summary["verdict"] == "unknown"
    assert summary["effects"] == []
