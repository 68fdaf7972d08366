"""Polynomials of the pressures as base, fitted to the run."""

from typing import TYPE_CHECKING

from labrig.model import Model

if TYPE_CHECKING:
    from tests.conftest import Lab


def fitted(lab: "Lab", degree: int) -> Model:
    """A model whose base is one of so high a degree, in the laboratory's folder."""
    path = lab.folder / "fitted.yaml"
    path.write_text(f"base: {{kind: static, degree: {degree}}}\n")
    return Model.load(path)
