"""model.yaml: read, refused, written, and read again."""

import zipfile
from pathlib import Path

import pytest
import yaml

from labrig._errors import LabrigError
from labrig.effects import write_template
from labrig.model import EffectEntry, Model, Value, read_model_file, write_model_file

TEXT = """\
base: {kind: static, degree: 2}
effects:
- name: leak
  form: per chamber
  parameters:
    loss:
      value: [1.0, 0.5]
      sd: [0.01, 0.02]
      unit: '1'
      per: [c1, c2]
    tau_s: {value: 40.0, unit: s}
"""


def refused(path: Path) -> str:
    """What reading this file says."""
    with pytest.raises(LabrigError) as error:
        read_model_file(path)
    assert "\n" not in str(error.value)
    return str(error.value)


@pytest.fixture
def path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A relative path in a folder of the test's own."""
    monkeypatch.chdir(tmp_path)
    return Path("model.yaml")


def test_a_model_is_written_as_it_was_read(path: Path) -> None:
    """Reading and writing change nothing but the layout; what nobody said is not written."""
    path.write_text(TEXT)
    model = read_model_file(path)
    again = Path("again.yaml")
    write_model_file(model, again)
    assert read_model_file(again) == model
    assert yaml.safe_load(again.read_text()) == yaml.safe_load(TEXT)
    assert sorted(p.name for p in Path().iterdir()) == ["again.yaml", "model.yaml"]


def test_a_model_shows_itself_in_one_line(path: Path) -> None:
    """In a notebook: base, effects and file, not every number of its family."""
    path.write_text(TEXT)
    assert repr(Model.load(path)) == "Model: static + leak (model.yaml)"
    assert repr(Model.of(lambda u: u)) == "Model: python, no effects"


def test_the_smallest_model(path: Path) -> None:
    """A base alone is a model; a static map is a straight line unless it says otherwise."""
    path.write_text("base: {kind: static}\n")
    model = read_model_file(path)
    assert model.base.kind == "static"
    assert model.base.degree == 1  # type: ignore[union-attr]
    assert model.effects == []


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", " is not a model: it should begin with `base: {kind: static, degree: 1}`"),
        ("- creep\n", " is not a model: it should begin with `base: {kind: static, degree: 1}`"),
        ("effects: []\n", ": base: is missing"),
        ("base: {kind: surrogate}\n", ", line 1: base: file: is missing"),
        (
            "base: {kind: magic}\n",
            ", line 1: base: kind: there is no 'magic'; "
            "there are 'python', 'ode', 'fmu', 'table', 'static', 'simulator', 'surrogate'",
        ),
        ("base: {degree: 1}\n", ", line 1: base: kind: is missing"),
        (
            "base: {kind: static, degree: 4}\n",
            ", line 1: base: degree: should be less than or equal to 3, not 4",
        ),
        ("base: {kind: python}\n", ", line 1: base: file: is missing"),
        (
            "base: {kind: static, file: x.py}\n",
            ", line 1: base: file: there is no such field; there are kind, degree, in_each_session",
        ),
        (
            "base: {kind: static}\neffect: []\n",
            ", line 2: effect: there is no such field; did you mean effects?",
        ),
        (
            "base: {kind: static}\neffects: [creep]\n",
            ", line 2: effects: entry 1: should hold fields (name: value), not 'creep'",
        ),
        ("base: {kind: static}\neffects: [{form: play}]\n", ", line 2: effects: entry 1: name: is missing"),
        (
            "base: {kind: static}\neffects: [{name: creep, amplitude: 0.2}]\n",
            ", line 2: effects: creep: amplitude: there is no such field; there are name, form, fitted_on, parameters",
        ),
        (
            "base: {kind: static}\neffects: [{name: creep, parameters: {amplitude: {unit: '1'}}}]\n",
            ", line 2: effects: creep: parameters: amplitude: value: is missing",
        ),
    ],
)
def test_what_is_no_model_is_refused(path: Path, text: str, complaint: str) -> None:
    """One line: the file, the place in it, what is wrong."""
    path.write_text(text)
    assert refused(path) == f"model.yaml{complaint}"


def test_a_syntax_error_has_its_line(path: Path) -> None:
    """YAML's own complaint, with the line as an editor counts it."""
    path.write_text("base: {kind: static}\neffects: [\n")
    assert (
        refused(path)
        == "model.yaml, line 3: is not YAML (expected the node content, but found '<stream end>')"
    )


def test_a_learned_model_is_no_model_file(path: Path) -> None:
    """Who names forward.pt where a model file is asked for is told what to write into one."""
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("facts.json", "{}")
    assert refused(path) == (
        "model.yaml is a learned model, which a model file names as its base: write one, such as "
        "`base: {kind: surrogate, file: model.yaml}`"
    )


def test_files_that_cannot_be_read(path: Path) -> None:
    """No file, a folder, and bytes that are no text."""
    assert refused(path) == "cannot read the model model.yaml: No such file or directory"
    path.write_bytes(b"base: \xff\xfe")
    assert refused(path) == "model.yaml is not a text file; a model is YAML"
    path.unlink()
    path.mkdir()
    assert refused(path).startswith("cannot read the model model.yaml: ")


def test_an_unknown_effect_is_refused_at_once(path: Path) -> None:
    """Loading checks the names of the effects, not only their layout."""
    path.write_text("base: {kind: static}\neffects: [{name: crep}]\n")
    with pytest.raises(LabrigError) as error:
        Model.load(path)
    assert str(error.value).startswith("there is no effect 'crep'; choose one of: contact, coupling, creep, ")


def test_an_effect_is_appended_and_nothing_else_changes(path: Path) -> None:
    """Saving with one more entry leaves the base and the entries before it as they were."""
    path.write_text(TEXT)
    model = Model.load(path)
    entry = EffectEntry(name="frame", parameters={"shift": Value(value=[0.0] * 6, unit="mm")})
    more = model.with_effect(entry)
    assert model.file.effects[0].name == "leak"
    assert len(model.file.effects) == 1
    more.save("new.yaml")
    old, new = (yaml.safe_load(Path(p).read_text()) for p in ("model.yaml", "new.yaml"))
    assert new["base"] == old["base"]
    assert new["effects"][:-1] == old["effects"]
    assert new["effects"][-1] == {
        "name": "frame",
        "parameters": {"shift": {"value": [0.0] * 6, "unit": "mm"}},
    }


def test_paths_follow_a_model_to_another_folder(path: Path) -> None:
    """A base's file is found from where the model is saved, however far away."""
    Path("lib").mkdir()
    Path("out/deep").mkdir(parents=True)
    Path("lib/base.py").write_text("def predict(u):\n    return u\n")
    path.write_text("base: {kind: python, file: lib/base.py}\n")
    Model.load(path).save("out/deep/model.yaml")
    assert read_model_file(Path("out/deep/model.yaml")).base.file == "../../lib/base.py"  # type: ignore[union-attr]


@pytest.mark.parametrize("written", [".nan", ".inf", "[1.0, .nan]"])
def test_a_value_that_is_no_number_is_refused_where_it_stands(path: Path, written: str) -> None:
    """Nothing could be predicted with it: the file, the line and the field are named."""
    path.write_text(TEXT.replace("40.0", written))
    assert refused(path).startswith("model.yaml, line 11: effects: leak: parameters: tau_s: value")
    assert "finite number" in refused(path)


def test_own_effects_follow_a_model_to_another_folder(path: Path) -> None:
    """A model that is saved elsewhere can be read there: an effect of your own goes along, with what it imports, and
    overwrites nothing.
    """
    Path("lib").mkdir()
    own = write_template("sags", Path("lib"))
    own.with_name("_tables.py").write_text("POWER = 3\n")
    own.write_text("from _tables import POWER\n" + own.read_text())
    written = "base: {kind: static}\neffects:\n- {name: sags, form: linear, parameters: {}}\n"
    Path("lib/model.yaml").write_text(written)
    known = Model.load("lib/model.yaml")
    Path("out").mkdir()
    known.save("out/model.yaml")
    assert [e.name for e in Model.load("out/model.yaml").file.effects] == ["sags"]
    Path("out/effects/sags.py").write_text(f"# changed\n{own.read_text()}")
    known.save("out/model.yaml")
    assert Path("out/effects/sags.py").read_text().startswith("# changed")
