"""A short run of the fuzzing that benchmarks/fuzz.py does at length."""

import importlib.util
from pathlib import Path

import pytest

FUZZ = Path(__file__).parents[2] / "benchmarks" / "fuzz.py"


def load():
    """The module, which is no package."""
    spec = importlib.util.spec_from_file_location("fuzz", FUZZ)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


PARSERS = [
    "vicon client",
    "vicon twin",
    "openpneu driver",
    "openpneu twin",
    "modbus driver",
    "scan files",
    "recordings",
]


@pytest.mark.parametrize("name", PARSERS)
def test_damaged_input_ends_in_events_or_the_parsers_own_error(name):
    """Three thousand damaged inputs (of scan files, a thousand): no crash, nothing slow, memory that stays small."""
    result = load().fuzz(name, 1000 if name == "scan files" else 3000, seed=1)
    assert result["findings"] == []
    assert result["peak_kb"] < 20_000


def test_every_parser_is_fuzzed():
    """The parsers that are fuzzed here are all that the benchmark knows."""
    assert list(load().PARSERS) == PARSERS


def test_a_parser_that_crashes_is_found():
    """A finding is reported with the input that caused it."""
    module = load()

    def crashing(chance):
        def read(data):
            raise KeyError("oops")

        return [b"abc"], read

    module.PARSERS["crashing"] = crashing
    finding = module.fuzz("crashing", 5, seed=0)["findings"][0]
    assert finding.startswith("KeyError: 'oops': ")
