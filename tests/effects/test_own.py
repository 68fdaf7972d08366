"""Effects in files of people's own: what is wrong with them is said with its place, and a diagnosis goes on."""

import pickle
from pathlib import Path

import pytest

from labrig._errors import LabrigError
from labrig.diagnosis import compare, diagnose
from labrig.effects import Effect, get, library, rows_of
from labrig.effects._own import EffectError
from labrig.experiment._probes import by_hand
from labrig.model import Model

HEAD = '''"""Boom: breaks."""

from labrig.effects import Effect, Parameter, Term, Variant
import numpy as np


class Boom(Effect):
    name = "boom"
    meaning = reference = signature = experiment = "x"
    acts_on = "pressure"
    parameters = (Parameter("amplitude", "1", -1.0, 1.0, meaning="x"),)

    def variants(self, context):
        u = context.rows.actuation
'''
FINE = 'yield Variant("a", (Term.common("amplitude", u * context.rows.fraction**3),))'
TERM = "form 'a': the term of "


@pytest.fixture(autouse=True)
def _desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def written(body: str, name: str = "boom") -> Path:
    """The file of an effect with this last line."""
    file = Path("effects") / f"{name}.py"
    file.parent.mkdir(exist_ok=True)
    file.write_text(f"{HEAD.replace('boom', name)}        {body}\n", encoding="utf-8")
    return file


def forms(effect: Effect, lab) -> list:
    """The forms that it yields on a small run."""
    rows = rows_of(lab.dataset(lab.predict(lab.u) + lab.noise()))
    return list(effect.variants(lab.model().context(rows)))


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("raise KeyError('temperature')", "boom.py, line 15: Boom.variants: KeyError: 'temperature'"),
        (FINE.replace("amplitude", "amplitud"), f"{TERM}'amplitud' has a coefficient that is none of its"),
        (
            FINE.replace("u *", "np.nan * u *"),
            f"{TERM}'amplitude' is not finite in 36 of 36 rows; yield no form",
        ),
        (
            'yield Variant("a", (Term.common("amplitude", u[:, :1]),))',
            f"{TERM}'amplitude' has shape (36, 1, 1), where (36, 3, q) is needed: rows, chambers, columns",
        ),
        (
            'yield Variant("a", (Term("amplitude", "patern", u),))',
            f"{TERM}'amplitude' is of kind 'patern'; there are pressure, pattern, frame, field",
        ),
        (
            'yield Variant("a", (Term.common("amplitude", u[:, 0]),))',
            "boom.py, line 15: Boom.variants: ValueError: Term.common('amplitude'): shape (36,) was given, where "
            "(rows, chambers) is needed",
        ),
        (
            'yield Variant("a", (Term.per_chamber("amplitude", u[:, :2], ("c1", "c2", "c3")),))',
            "Term.per_chamber('amplitude'): 2 columns, where the 3 chambers have one each",
        ),
        (
            'yield Variant("a", (Term.field("amplitude", 3.0),))',
            "Term.field('amplitude'): a float was given, where (rows, observables) or ",
        ),
        ('yield Variant("a", (u,))', "form 'a': a term is a ndarray, where a Term is needed"),
        ("yield u", "yields a ndarray, where a Variant is needed"),
        (
            FINE.replace("3),))", '3),), {"tau_s": 3.0})'),
            "form 'a': 'tau_s' is none of its parameters (amplitude)",
        ),
    ],
)
def test_what_an_own_effect_does_wrong_is_said(make_lab, body: str, said: str) -> None:
    """The file, the method, the form and the term are named: it is no bug of labrig's, and nothing vanishes."""
    written(body)
    with pytest.raises(LabrigError) as caught:
        forms(get("boom"), make_lab(captures=12))
    message = str(caught.value)
    assert message.startswith("effect 'boom': boom.py")
    assert said in message
    assert "\n" not in message


@pytest.mark.parametrize(
    ("method", "arguments"),
    [("follows", ()), ("turned_round", ()), ("lacks", ("a", ())), ("carried", ("a", {})), ("in_words", ())],
)
def test_each_method_of_an_own_effect_says_where_it_fails(make_lab, method: str, arguments: tuple) -> None:
    """A fault in any of the methods that people are told to write is said as one in the forms is."""
    file = written(FINE)
    given = "".join(f", a{i}" for i in range(len(arguments)))
    method_text = f"\n    def {method}(self, context{given}):\n        return 1 / 0\n"
    file.write_text(file.read_text() + method_text)
    lab = make_lab(captures=12)
    context = lab.model().context(rows_of(lab.dataset(lab.predict(lab.u))))
    with pytest.raises(LabrigError) as caught:
        getattr(get("boom"), method)(context, *arguments)
    assert str(caught.value).startswith(f"effect 'boom': boom.py, line 18: Boom.{method}: ZeroDivisionError")


def test_a_fault_of_an_own_effect_reaches_another_process(make_lab) -> None:
    """The workbench computes in a process of its own: what is said of an effect comes back from there as it is."""
    written("raise KeyError('temperature')")
    with pytest.raises(EffectError) as caught:
        forms(get("boom"), make_lab(captures=12))
    back = pickle.loads(pickle.dumps(caught.value))
    assert (type(back), str(back), back.effect) == (EffectError, str(caught.value), "boom")


def test_two_files_with_one_name_are_refused() -> None:
    """A copy of a file whose effect was not given a name of its own would take the place of the first."""
    first, second = written(FINE), Path("effects") / "copy.py"
    second.write_text(first.read_text())
    with pytest.raises(LabrigError) as caught:
        library()
    assert str(caught.value) == (
        f"{Path.cwd() / second.parent / 'copy.py'}: boom.py has an effect named 'boom' already; give one another name"
    )


def test_a_diagnosis_goes_on_without_an_effect_that_fails(make_lab) -> None:
    """One file with a mistake does not keep the library from its answer; a warning says that it is left out."""
    written("raise KeyError('temperature')")
    lab = make_lab(chambers=2, captures=12)
    found = diagnose(lab.dataset(lab.predict(lab.u) + lab.noise()), lab.model())
    assert found.summary["verdict"] == "nothing_missing"
    line = next(w for w in found.summary["warnings"] if "boom" in w)
    assert line == ("effect 'boom': boom.py, line 15: Boom.variants: KeyError: 'temperature'; it is left out")


def test_a_diagnosis_goes_on_without_a_file_that_is_no_python(make_lab) -> None:
    """A slip in one file stops no command: the file and its line are in a warning, and a model without it is loaded."""
    file = written("yield (")
    lab = make_lab(chambers=2, captures=12)
    found = diagnose(lab.dataset(lab.predict(lab.u) + lab.noise()), lab.model())
    assert found.summary["verdict"] == "nothing_missing"
    (line,) = [w for w in found.summary["warnings"] if "boom" in w]
    assert line == f"{file.resolve()}, line 15: is no Python ('(' was never closed); it is left out"
    (lab.folder / "own.yaml").write_text(
        "base: {kind: static}\neffects: [{name: boom, form: a, parameters: {}}]\n"
    )
    with pytest.raises(
        LabrigError, match=r"there is no effect 'boom', and an effect's file can't be read: .*line 15"
    ):
        Model.load(lab.folder / "own.yaml")


def test_a_comparison_goes_on_without_it_too(make_lab) -> None:
    """All effects are asked for the noise of a single sensor; one that fails is not, and the error stays the same."""
    lab = make_lab(captures=30, force=True)
    run, model = lab.dataset(lab.predict(lab.u) + lab.noise()), lab.model()
    before = compare(run, model).summary["error"]
    written("raise KeyError('temperature')")
    assert compare(run, model).summary["error"] == before


def test_an_effect_that_does_nothing_wrong_is_as_it_was(make_lab) -> None:
    """Its forms are its own, and its source is found."""
    written(FINE)
    effect = get("boom")
    assert [variant.key for variant in forms(effect, make_lab(captures=12))] == ["a"]
    assert type(effect).family is Effect.family


def test_a_name_of_the_library_is_refused() -> None:
    """An own file does not take the place of one of labrig's effects without a word."""
    file = written(FINE, "creep")
    with pytest.raises(LabrigError) as caught:
        library()
    assert str(caught.value) == (
        f"{file.resolve()}: labrig has an effect named 'creep' already; give yours another name"
    )


def test_an_own_effect_says_what_a_person_can_do() -> None:
    """What only somebody at the rig can do for one's own effect is offered beside a programme, as for labrig's."""
    file = written(FINE)
    file.write_text(
        file.read_text().replace(
            'acts_on = "pressure"', 'acts_on = "pressure"\n    by_hand = "open the lid"', 1
        )
    )
    hidden = by_hand(["boom", "creep", "gravity"], library())
    assert hidden[0] == {"effect": "boom", "what": "open the lid", "points": False}
    assert [(each["effect"], each["points"]) for each in hidden[1:]] == [("gravity", True)]
