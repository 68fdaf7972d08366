"""The changes that benchmarks/safety_mutants.py makes can be made, and one that cannot is named."""

import importlib.util
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

PATH = Path(__file__).parents[1] / "benchmarks" / "safety_mutants.py"


@pytest.fixture(scope="module")
def mutants() -> Any:
    """The benchmark as a module."""
    spec = importlib.util.spec_from_file_location("safety_mutants", PATH)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["safety_mutants"] = module
    spec.loader.exec_module(module)
    return module


def test_every_change_can_be_made(mutants: Any) -> None:
    """Code that was edited takes its changes along: correct safety_mutants.yaml where this fails, and run it again."""
    changes = mutants.load_changes(mutants.LIST)
    assert [problem for change in changes if (problem := change.problem(mutants.ROOT)) is not None] == []
    assert len({change.change for change in changes}) == len(changes) >= 30


def test_a_change_that_cannot_be_made_is_named(mutants: Any, tmp_path: Path) -> None:
    """Text that is gone or stands twice, a file or tests that are not there, and what is no Python afterwards."""
    (tmp_path / "code.py").write_text("limit = 3\nother = 4\nother = 4\n", encoding="utf-8")
    change = mutants.Change("a", "b", "code.py", "limit = 3", "limit = 30", (".",))
    assert change.problem(tmp_path) is None
    assert change.apply(tmp_path) == "limit = 3\nother = 4\nother = 4\n"
    assert (tmp_path / "code.py").read_text(encoding="utf-8").startswith("limit = 30\n")
    for wrong, text in (
        (
            {"before": "limit = 4"},
            "its text stands 0 times in code.py, not once; correct safety_mutants.yaml",
        ),
        (
            {"before": "other = 4"},
            "its text stands 2 times in code.py, not once; correct safety_mutants.yaml",
        ),
        ({"after": "limit ="}, "code.py would be no Python any more, line 1"),
        ({"file": "gone.py"}, "there is no file gone.py"),
        ({"tests": ("tests/gone",)}, "there are no tests tests/gone"),
    ):
        assert replace(change, **{"before": "limit = 30", **wrong}).problem(tmp_path) == f"a: {text}"
