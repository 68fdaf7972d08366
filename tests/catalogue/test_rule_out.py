"""labrig rule-out: what somebody saw to it cannot act, kept with the run and read with it."""

import inspect
import json
import shutil
from pathlib import Path

import pytest
import yaml

from labrig import LabrigError, improve, open_run, rule_out
from labrig.catalogue import list_runs, note, read_notes
from labrig.diagnosis._about import about
from labrig.effects import gravity, join_rows, rows_of
from labrig.log import write_dataset
from tests.conftest import Lab


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """A run of 12 captures, in the sessions s0 and s1."""
    lab = Lab(tmp_path, captures=12, sessions=2)
    return write_dataset(lab.dataset(lab.predict(lab.u) + lab.noise()), tmp_path / "second", run_yaml={})


def test_what_is_ruled_out_goes_with_the_run(run: Path, labrig) -> None:
    """It is said in one line, kept in notes.yaml beside what else is said, and opened with the run or its log."""
    note(run, "the bench is empty")
    assert labrig("rule-out", run, "contact") == (0, f"{run}: ruled out: contact\n", "")
    kept = yaml.safe_load((run / "notes.yaml").read_text())
    assert kept == {"tags": [], "notes": ["the bench is empty"], "ruled_out": {"contact": []}}
    for path in (run, run / "log.000.mcap"):
        opened = open_run(path)
        assert list(opened["ruled_out"].values) == ["contact"] * 12
        assert rows_of(opened).ruled_out == (frozenset({"contact"}),) * 12


def test_of_a_log_alone_nothing_can_be_said(run: Path, tmp_path: Path, labrig) -> None:
    """Its notes would lie beside whatever else is there: the message says how it gets a folder."""
    (made := tmp_path / "made").mkdir()
    alone = shutil.copy(run / "log.000.mcap", tmp_path / "alone.mcap")
    code, _, err = labrig("rule-out", alone, "contact")
    assert (code, err.endswith(": name that, or put the log into one of its own, as log.000.mcap\n")) == (
        2,
        True,
    )
    shutil.move(alone, made / "log.000.mcap")
    assert labrig("rule-out", made, "contact")[0] == 0


def test_it_may_hold_in_some_sessions_only(run: Path, labrig) -> None:
    """Captures of other sessions have nothing ruled out; more than one effect may be."""
    labrig("rule-out", run, "frame")
    said = f"{run}: ruled out: contact (in s1), frame\n"
    assert labrig("rule-out", run, "contact", "--session", "s1") == (0, said, "")
    assert list(open_run(run)["ruled_out"].values) == ["frame"] * 6 + ["frame contact"] * 6


def test_it_can_be_taken_back(run: Path, labrig) -> None:
    """What is no longer ruled out is in no capture, and the file of notes has no word of it."""
    labrig("rule-out", run, "contact")
    assert labrig("rule-out", run, "contact", "--remove") == (0, f"{run}: nothing is ruled out\n", "")
    assert "ruled_out" not in open_run(run).coords
    assert "ruled_out" not in (run / "notes.yaml").read_text()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["contacts"], "there is no effect 'contacts'; did you mean contact?"),
        (["contact", "--session", "s7"], "{run} has no session 's7' (it has s0 and s1)"),
        (["contact", "--remove"], "{run}: contact is not ruled out there"),
    ],
)
def test_what_cannot_be_ruled_out_is_refused(run: Path, labrig, words: list[str], said: str) -> None:
    """A misspelt effect, a session that is not there, something that is to be taken back and is not there."""
    code, out, err = labrig("rule-out", run, *words)
    assert (code, out, err) == (2, "", f"labrig: {said.format(run=run)}\n")
    assert not (run / "notes.yaml").exists()


def test_sessions_are_said_one_after_the_other(run: Path, labrig) -> None:
    """A session that is named later is one more; one that is taken back leaves the others, in a Dataset as well."""
    labrig("rule-out", run, "contact", "--session", "s0")
    said = f"{run}: ruled out: contact (in s0, s1)\n"
    assert labrig("rule-out", run, "contact", "--session", "s1") == (0, said, "")
    both = open_run(run)
    said = f"{run}: ruled out: contact (in s1)\n"
    assert labrig("rule-out", run, "contact", "--session", "s0", "--remove") == (0, said, "")
    assert list(open_run(run)["ruled_out"].values) == [""] * 6 + ["contact"] * 6
    assert list(rule_out(both, "contact", sessions="s0", remove=True)["ruled_out"].values) == (
        [""] * 6 + ["contact"] * 6
    )
    said = f"labrig: {run}: contact is not ruled out in s0\n"
    assert labrig("rule-out", run, "contact", "--session", "s0", "--remove") == (2, "", said)


@pytest.mark.parametrize("more", [(), ("--remove",)])
def test_some_sessions_of_all_are_refused(run: Path, labrig, more: tuple[str, ...]) -> None:
    """Whoever said it of all of a run and means a part has to take it back first: neither is guessed."""
    labrig("rule-out", run, "contact")
    code, _, err = labrig("rule-out", run, "contact", "--session", "s1", *more)
    said = (
        "contact is ruled out in all of it; take that back first (--remove), then say in which sessions it is"
    )
    assert (code, err) == (2, f"labrig: {run}: {said}\n")
    assert read_notes(run).ruled_out == {"contact": []}


@pytest.mark.parametrize(
    ("written", "means"),
    [
        ("[contact, frame]", {"contact": [], "frame": []}),
        ("contact", {"contact": []}),
        ("{contact: , frame: s1}", {"contact": [], "frame": ["s1"]}),
        ("", {}),
    ],
)
def test_whoever_writes_it_by_hand_may_leave_brackets_out(run: Path, written: str, means) -> None:
    """Names alone are ruled out in all of the run, and one session needs no list."""
    (run / "notes.yaml").write_text(f"ruled_out: {written}\n")
    assert read_notes(run).ruled_out == means


@pytest.mark.parametrize(
    ("written", "wrong"),
    [
        ("[contact: [s1]]", "should hold fields (name: value), not a list"),
        ("[marker slip]", "'marker slip' is no name of an effect; labrig effects list has them"),
    ],
)
def test_what_is_written_wrongly_is_said_with_its_file(run: Path, written: str, wrong: str) -> None:
    """A run whose file of notes is damaged is opened once that is put right."""
    (run / "notes.yaml").write_text(f"ruled_out: {written}\n")
    with pytest.raises(LabrigError) as caught:
        open_run(run)
    assert str(caught.value) == f"{run / 'notes.yaml'}, line 1: ruled_out: {wrong}"


def test_an_effect_of_ones_own_may_lie_beside_the_run(run: Path, labrig) -> None:
    """It need not lie where the command is given; one that lies in neither place is not there."""
    code, _, err = labrig("rule-out", run, "bulge")
    own = "those of your own are looked for in effects/, here and beside the run"
    assert (code, err) == (2, f"labrig: there is no effect 'bulge'; {own}\n")
    (run.parent / "effects").mkdir()
    source = inspect.getsource(gravity).replace('name = "gravity"', 'name = "bulge"')
    (run.parent / "effects" / "bulge.py").write_text(source, encoding="utf-8")
    assert labrig("rule-out", run, "bulge")[0] == 0


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ((["a", "b"], "contact"), "a run is needed, and a list was given: "),
        (("a", ["contact"]), "an effect is needed, and a list was given: its name, such as 'contact'"),
    ],
)
def test_what_is_no_run_or_no_name_is_said(given, said: str) -> None:
    """In a notebook several runs or several names are refused in one line."""
    with pytest.raises(LabrigError) as caught:
        rule_out(*given)
    assert str(caught.value).startswith(said)


def test_what_was_found_before_is_not_listed(run: Path, tmp_path: Path) -> None:
    """A result took for possible what is ruled out by now, in its run or in one that it joins; also from the index."""

    def listed() -> list[str]:
        first, second = ([row.verdict for row in list_runs(tmp_path)] for _ in range(2))
        assert first == second
        return first

    lab = Lab(tmp_path, captures=12, seed=1)
    first = write_dataset(lab.dataset(lab.predict(lab.u) + lab.noise()), tmp_path / "first", run_yaml={})
    of = about([open_run(first), open_run(run)], lab.model())
    result = tmp_path / "diagnosis.json"
    result.write_text(json.dumps({"verdict": "unknown", "error": {"base": 1.0}, **of}))
    assert listed() == ["unknown", "unknown"]
    rule_out(run, "frame", sessions="s1")
    assert listed() == ["", ""]
    result.write_text(
        json.dumps({"verdict": "confounded", "error": {"base": 1.0}, **about(open_run(run), lab.model())})
    )
    assert listed() == ["", "confounded"]
    rule_out(run, "frame", sessions="s0")
    assert listed() == ["", ""]


def test_of_a_copy_the_result_is_that_of_its_own_notes(run: Path, tmp_path: Path) -> None:
    """A copy of a run in which something is ruled out, and the run itself, have results of their own."""
    result = tmp_path / "diagnosis.json"
    of = about(open_run(run), Lab(tmp_path).model())
    result.write_text(json.dumps({"verdict": "unknown", "error": {"base": 1.0}, **of}))
    rule_out(shutil.copytree(run, tmp_path / "copy"), "frame")
    assert {row.run: row.verdict for row in list_runs(tmp_path)} == {"copy": "", "second": "unknown"}


def test_a_result_says_what_was_ruled_out_as_the_notes_do(run: Path, tmp_path: Path) -> None:
    """All of a run or some sessions of it, by name: results of before and after a change can be told apart."""
    lab = Lab(tmp_path, captures=12)
    for sessions in ((), ("s1",)):
        rule_out(run, "frame" if sessions else "contact", sessions=sessions)
        (named,) = about(open_run(run), lab.model())["runs"]
        assert ", ".join(named["ruled_out"]) == read_notes(run).ruled_out_in_words
    assert named["ruled_out"] == ["contact", "frame (in s1)"]


def test_a_session_that_the_run_does_not_have_is_said_when_it_is_opened(run: Path) -> None:
    """A file of notes that names another session is wrong, and the run is not opened as if it were not there."""
    (run / "notes.yaml").write_text("ruled_out: {contact: [s9]}\n")
    with pytest.raises(LabrigError) as caught:
        open_run(run)
    said = f"contact is ruled out in session 's9', and the run has s0 and s1; labrig rule-out {run} contact --remove"
    assert str(caught.value) == f"{run / 'notes.yaml'}: {said} takes it back"


def test_such_a_session_can_be_taken_back(run: Path, labrig) -> None:
    """A run that lost a session in being recovered is not closed for ever."""
    (run / "notes.yaml").write_text("ruled_out: {contact: [s9]}\n")
    assert labrig("rule-out", run, "contact", "--remove") == (0, f"{run}: nothing is ruled out\n", "")
    assert "ruled_out" not in open_run(run).coords


def test_a_dataset_says_it_in_a_coordinate(run: Path) -> None:
    """In a notebook it is said of a Dataset, which stays as it was; the file is left alone."""
    opened = open_run(run)
    said = rule_out(rule_out(opened, "contact"), "frame", sessions=["s0"])
    assert list(said["ruled_out"].values) == ["contact frame"] * 6 + ["contact"] * 6
    assert list(rule_out(said, "contact", remove=True)["ruled_out"].values) == ["frame"] * 6 + [""] * 6
    assert "ruled_out" not in opened.coords
    assert not (run / "notes.yaml").exists()


def test_runs_together_keep_what_is_ruled_out_in_each(run: Path) -> None:
    """Of several runs as one campaign, only those captures have it ruled out that had it before."""
    first, second = open_run(run), rule_out(open_run(run), "contact")
    joined = join_rows([rows_of(first), rows_of(second)])
    assert joined.ruled_out == (frozenset(),) * 12 + (frozenset({"contact"}),) * 12


def test_what_could_never_act_is_not_fitted(run: Path, tmp_path: Path) -> None:
    """An effect is not added to a model from runs in all of which it was ruled out, not even by force."""
    model = Lab(tmp_path, captures=12, sessions=2).model()
    with pytest.raises(LabrigError) as caught:
        improve(rule_out(open_run(run), "creep"), model, "creep", force=True)
    assert str(caught.value) == "creep was ruled out in all of these captures: give a run in which it can act"
