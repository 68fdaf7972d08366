"""Laws that hold in one of several chambers."""

import numpy as np

from labrig.bench import draw, half_of, make_rig
from labrig.bench._in_one import FEWEST, InOneChamber, acts_in_chambers
from labrig.bench._nature import Setting
from labrig.bench._path import make_path
from labrig.bench._programmes import make_plan


def test_only_one_chamber_is_changed() -> None:
    """Of every law that acts through pressures or walls, what comes to pass is what it does in that chamber."""
    recipe = {"half": "development", "rig": "pads", "rig_seed": 1, "linear": False}
    rig, random = make_rig(recipe), np.random.default_rng(0)
    path = make_path(make_plan("holds", random, rig.high_kpa, 30, True, False, 0.1, False, rig.low_kpa))
    clean = rig.deflection(path.kpa)
    acting = [law for laws in half_of("development").laws.values() for law in laws if acts_in_chambers(law)]
    changed = 0
    for of_law in acting:
        whole = of_law(Setting(rig, path, np.random.default_rng(1)))
        law = InOneChamber(whole, 1)
        kpa = law.pressure(path, path.kpa, 1.0)
        walls = law.wall(path, kpa, rig.deflection(kpa), 1.0)
        own = whole.pressure(path, path.kpa, 1.0)[:, 1]
        assert np.array_equal(kpa[:, 1], own)
        for c in {*range(len(rig.chambers))} - {1}:
            assert np.array_equal(kpa[:, c], path.kpa[:, c])
            assert np.allclose(walls[:, c], clean[:, c])
        changed += not np.allclose(walls[:, 1], clean[:, 1])
    assert changed == len(acting) >= 2


def test_a_campaign_of_one_chamber() -> None:
    """The rig has several, the law is one of those that act in chambers, and the verdict is its name alone."""
    truth = draw("one-chamber", 3, captures=40).truth
    (effect,), (name,) = truth["effects"], truth["laws"]
    assert name in {law.__name__ for law in half_of("development").laws[effect] if acts_in_chambers(law)}
    assert (truth["verdict"], truth["class"]) == ("identified", "one-chamber")
    assert 2.0 <= truth["amplitudes"][effect] <= 4.05
    assert len(draw("one-chamber", 3, captures=40).dataset["chamber"]) >= FEWEST
