"""A leak loses air: chambers that fill slowly are none, however well a fast leak less a slow one describes them."""

from dataclasses import replace

import numpy as np
import pytest

from labrig.effects import rows_of
from labrig.effects.leak import Leak
from labrig.model import Model
from labrig.view._naming import carries
from tests.naming import verdict_of

RISES = "what rises during a hold"


def test_a_vent_that_the_table_does_not_tell_of_is_no_leak(make_lab, tmp_path) -> None:
    """Chambers that are empty at the beginning of each hold, and fill at a constant speed."""
    lab = make_lab(chambers=3, rows_s=(0.2, 0.6, 1.2, 2.5, 5.0), captures=60)
    filled = np.minimum(lab.u, 0.5 * lab.u.max() * lab.hold_s[..., None])
    (tmp_path / "model.yaml").write_text("base: {kind: static, degree: 1}\n", encoding="utf-8")
    found = verdict_of(lab.dataset(lab.predict(filled) + lab.noise()), Model.load(tmp_path / "model.yaml"))
    assert "leak" not in (*found.effects, *found.rivals)


def test_a_leak_is_a_leak_and_what_fills_is_said(make_lab) -> None:
    """Of a loss by the root of the pressure the same words say nothing; turned round, they say that it fills."""
    lab = make_lab(chambers=2, rows_s=(1.0, 2.0, 5.0, 20.0), captures=60)
    context = lab.model().context(rows_of(lab.dataset(lab.predict(lab.u) + lab.noise())))
    lost = np.clip(np.sqrt(lab.u) - 0.05 * lab.hold_s[..., None], 0.0, None) ** 2 - lab.u
    moved = np.einsum("fkc,fc->fk", context.jacobian, lost.reshape(-1, 2))
    for sign, said in ((1.0, ""), (-1.0, RISES)):
        seen = context.rows.values + sign * moved
        changed = replace(context, rows=replace(context.rows, values=seen), _memo={})
        assert Leak().turned_round(changed) == said


@pytest.mark.parametrize("seed", [0, 1])
def test_what_rises_in_every_hold_is_no_leak_however_noisy(make_lab, seed: int) -> None:
    """Pressures that go on rising by a twentieth, ever more slowly, beside noise that hides it in most single holds."""
    lab = make_lab(chambers=3, captures=60, rows_s=(2.0, 6.0, 12.0, 20.0), markers=5, seed=seed)
    t = lab.hold_s[..., None]
    risen = lab.u * (1 + 0.06 * t / (t + 5.0))
    found = verdict_of(lab.dataset(lab.predict(risen) + lab.noise(0.3, 0.3)), lab.model())
    assert found.verdict == "unknown"
    assert "leak" not in found.rivals


def test_what_to_do_is_said() -> None:
    """The table is to tell of the vents."""
    assert carries(RISES).startswith("rises during a hold, as no leak does: chambers that fill slowly")
