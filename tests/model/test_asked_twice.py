"""A function that remembers what it was asked before is no model of the pressures."""

from pathlib import Path

import pytest

from labrig import LabrigError
from labrig.effects import rows_of
from labrig.model import Model


@pytest.mark.parametrize(
    "code",
    [
        "calls = []\n\ndef predict(u):\n    calls.append(u)\n    return u[:, :1] + len(calls)\n",
        "last = 0.0\n\ndef predict(u):\n    global last\n    out = []\n    for row in u:\n"
        "        last = 0.5 * last + row[0]\n        out.append([last])\n    return out\n",
        "import numpy as np\n\ndef predict(u):\n    return u[:, :1] * (1 + 0.1 * np.random.rand(len(u), 1))\n",
    ],
    ids=["counts its calls", "remembers the row before", "draws at random"],
)
def test_a_function_that_remembers(make_lab, monkeypatch: pytest.MonkeyPatch, code: str) -> None:
    """A function whose answer depends on what it was asked before is no model of the pressures, and is refused."""
    bench = make_lab(force=True)
    monkeypatch.chdir(bench.folder)
    Path("own.py").write_text(code)
    Path("own.yaml").write_text("base: {kind: python, file: own.py}\n")
    with pytest.raises(LabrigError, match="answers otherwise when it is asked again in another order"):
        Model.load("own.yaml").context(rows_of(bench.dataset(bench.predict(bench.u))))
