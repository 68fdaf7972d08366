"""What a diagnosis holds in memory at once: of many captures there is no room for all that it ever needs."""

import gc
from typing import Any

import pytest

from labrig.diagnosis import _diagnose, diagnose
from labrig.diagnosis._design import Design
from labrig.diagnosis._diagnose import laid_out
from labrig.diagnosis._problem import prepared
from labrig.effects import rows_of


def designs() -> list[Design]:
    """Those that somebody still holds."""
    return [
        one for one in gc.get_objects() if type(one) is Design
    ]  # isinstance would ask lazy ones for their class


@pytest.mark.parametrize("ruled_out", [False, True])
def test_columns_are_let_go_before_formulas(
    make_lab: Any, monkeypatch: pytest.MonkeyPatch, ruled_out: bool
) -> None:
    """Once effects have names nothing holds the columns that evidence was worked out from, no cycle either."""
    lab = make_lab(captures=30, chambers=1, markers=3)
    run = lab.dataset(lab.predict(lab.looped(4.0)) + lab.noise())
    if ruled_out:
        names = ["contact" if capture >= 15 else "" for capture in range(30)]
        run = run.assign_coords(ruled_out=("capture", names))
    held: list[int] = []
    then = _diagnose.result_of

    def counted(*given: Any) -> Any:
        held.append(len(designs()))
        return then(*given)

    monkeypatch.setattr(_diagnose, "result_of", counted)
    gc.collect()
    gc.disable()
    try:
        diagnose(run, lab.model())
    finally:
        gc.enable()
    assert held == [0]


def test_laid_out_spaces_have_no_features(make_lab: Any) -> None:
    """Columns take the place of what they were made from."""
    lab = make_lab(captures=30, chambers=2, markers=4)
    model = lab.model()
    ready = prepared(rows_of(lab.dataset(lab.predict(lab.u) + lab.noise())), model)
    design = laid_out(ready, model.library())[2]
    assert design is not None
    assert len(design.blocks) > 50
    assert not any(one.space.features for one in (*design.blocks, *design.free))
