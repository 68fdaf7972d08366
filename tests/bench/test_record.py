"""The track record: counted from campaigns, shipped, and said beside each verdict."""

import json
from typing import Any

from labrig.bench import times_there, track_records, write_track_records
from labrig.diagnosis._track_record import FILE, track_record
from labrig.diagnosis._track_record import times_there as shipped_times_there


def campaign(verdict: str, right: bool, named: str = "", hidden: str = "", also: str = "") -> Any:
    """A record of a campaign, as far as it counts here."""
    answer = {"verdict": verdict, "effects": named.split()}
    return {"answer": answer, "right": right, "truth": {"effects": hidden.split(), "also": also.split()}}


def test_verdicts_are_counted_by_their_word(tmp_path) -> None:
    """Right ones, and where all that is named was there; a verdict that leaves the answer open is not counted."""
    records = [
        campaign("identified", True, "leak", "leak"),
        campaign("identified", False, "leak", "leak creep"),
        campaign("identified", False, "creep", "leak"),
        campaign("multiple", True, "leak stiffening", "leak", also="stiffening"),
        campaign("unknown", False),
        campaign("confounded", True),
        campaign("underpowered", False),
    ]
    counted = {
        "identified": {"right": 1, "of": 3, "there": 2},
        "multiple": {"right": 1, "of": 1, "there": 1},
        "unknown": {"right": 0, "of": 1},
    }
    assert track_records(records) == counted
    write_track_records(records, tmp_path / "record.json", "how")
    written = json.loads((tmp_path / "record.json").read_text())
    assert (written["how"], written["verdicts"]) == ("how", counted)
    assert written["spectra"].startswith("labrig bench learn ")


def test_names_that_are_sure_are_counted() -> None:
    """Each name that was called sure, and whether it was there; what is possible only is not counted."""

    def considered(hidden: str, also: str = "", **probability: float) -> Any:
        rows = [{"effect": name, "probability": p} for name, p in probability.items()]
        truth = {"effects": hidden.split(), "also": also.split()}
        return {"answer": {"verdict": "multiple", "effects": [], "effects_considered": rows}, "truth": truth}

    records = [
        considered("leak", leak=0.95, creep=0.76, drift=0.5),
        considered("leak creep", leak=0.75, creep=0.74),
        considered("leak", also="stiffening", stiffening=0.99),
        considered("", drift=0.74),
    ]
    counted = {"creep": (0, 1), "leak": (2, 2), "stiffening": (1, 1)}
    assert times_there(records) == {name: {"there": t, "of": n} for name, (t, n) in counted.items()}


def test_what_is_shipped_was_counted_on_the_half_that_nothing_is_learnt_from() -> None:
    """Each verdict that makes a claim has its record, from enough campaigns, and says how it was made."""
    content = json.loads(FILE.read_text(encoding="utf-8"))
    assert "--half exam" in content["how"]
    assert content["spectra"].startswith("labrig bench learn ")
    assert sum(counted["of"] for counted in content["verdicts"].values()) >= 60
    for verdict in ("identified", "multiple", "nothing_missing", "unknown"):
        counted = track_record(verdict)
        assert counted is not None
        assert 0 <= counted["right"] <= counted.get("there", counted["of"]) <= counted["of"]
    assert track_record("confounded") is None
    for effect in ("creep", "leak", "hysteresis"):
        found = shipped_times_there(effect)
        assert found is not None
        assert 0 <= found["there"] <= found["of"]
    assert shipped_times_there("an effect of somebody's own") is None
