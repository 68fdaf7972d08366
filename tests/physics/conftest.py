"""Small shells for tests."""

import pytest

from labrig.physics import Shell, load_shell


@pytest.fixture(scope="session")
def sheet():
    """Makes a flat weightless square sheet of 100 mm, air under all of it and nothing else that holds it."""

    def make(count: int = 16, border: str = "hinged", degree: int = 2, **layer: float) -> Shell:
        return load_shell(
            {
                "name": "sheet",
                "control_points": [count, count],
                "degree": degree,
                "border": border,
                "core": {"kind": "plane", "width": 100, "height": 100},
                "layers": [{"modulus": 1000, "thickness": 2, "stiffening": 0.01, "density": 0, **layer}],
                "seam": 0,
                "adhesion": 0,
                "contact": 0,
                "chambers": [{"name": "air", "u": [-1, 2], "v": [-1, 2], "max": 1.0}],
                "markers": {"middle": [0.5, 0.5]},
            }
        )

    return make


@pytest.fixture(scope="session")
def small():
    """Makes a shipped shell on few control points."""

    def make(name: str = "mannequin", count: tuple[int, int] = (12, 12)) -> Shell:
        return load_shell(name).changed(count=count)

    return make
