"""The registry: labrig's effects, a user's own, and what is said when a file is no effect."""

from pathlib import Path

import numpy as np
import pytest

from labrig._errors import LabrigError
from labrig.diagnosis import diagnose
from labrig.effects import get, library, rows_of, write_template
from labrig.model import Model, base_context, build_base

NAMES = (
    "contact, coupling, creep, delay, drift, frame, friction, gravity, hysteresis, leak, marker_slip, "
    "regulator, rest_shape, stiffening, tension"
)


@pytest.fixture(autouse=True)
def _desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def complaint(*, name: str = "creep") -> str:
    """What `get` says."""
    with pytest.raises(LabrigError) as error:
        get(name)
    return str(error.value)


def test_an_unknown_name_lists_the_known_ones() -> None:
    """The complaint is a choice, with the name that was probably meant."""
    assert complaint(name="crep") == f"there is no effect 'crep'; choose one of: {NAMES}; did you mean creep?"


def test_an_unknown_effect_on_the_command_line(labrig, make_lab) -> None:
    """effects show, improve --add and a model file refuse it in the same words, with nothing written."""
    wanted = f"labrig: there is no effect 'crep'; choose one of: {NAMES}; did you mean creep?\n"
    assert labrig("effects", "show", "crep") == (2, "", wanted)
    from labrig.log import write_dataset

    lab = make_lab(captures=12)
    write_dataset(lab.dataset(lab.predict(lab.u) + lab.noise()), Path("run"), run_yaml={"procedure": "test"})
    lab.model()
    words = ("improve", "run", "--model", "model.yaml", "--add", "crep", "-o", "new.yaml")
    assert labrig(*words) == (2, "", wanted)
    assert not Path("new.yaml").exists()
    Path("bad.yaml").write_text("base: {kind: static}\neffects: [{name: crep}]\n")
    for command in ("compare", "diagnose"):
        assert labrig(command, "run", "--model", "bad.yaml", "--out", "out") == (2, "", wanted)
    assert not Path("out").exists()


def test_effects_are_listed_and_shown(labrig) -> None:
    """list names them all; show says everything about one."""
    code, out, err = labrig("effects", "list")
    assert (code, err) == (0, "")
    assert all(name in out for name in NAMES.split(", "))
    assert labrig("effects") == (0, out, "")
    code, out, err = labrig("effects", "show", "leak")
    assert (code, err) == (0, "")
    assert out.startswith("leak (acts on pressure)\n\nAir escapes from a held chamber, or into the next one")
    assert "  tau_s [s], 0.1 .. 1e+06: time constant of the escape\n" in out
    assert "\nexperiment: the same long hold at two pressures: a leak doubles" in out


def test_a_new_effect_works_at_once(labrig, make_lab) -> None:
    """The template is found by a diagnosis of data that have it, added to a model, and read back from there."""
    code, out, err = labrig("effects", "new", "swelling")
    file = Path.cwd() / "effects" / "swelling.py"
    assert (code, err) == (0, "")
    assert out == f"{file}: edit its formula; labrig effects list shows it\n"
    code, out, err = labrig("effects", "list")
    assert "swelling" in out
    lab = make_lab(chambers=2)
    u = lab.u * (1 + 0.2 * (lab.u / 60) ** 3)
    data = lab.dataset(lab.predict(u) + lab.noise())
    result = diagnose(data, lab.model(), without=["stiffening", "contact", "tension", "regulator"])
    assert "swelling" in result.summary["effects"]
    assert result.improved is not None
    result.improved.save("better.yaml")
    better = Model.load("better.yaml")
    entry = next(e for e in better.file.effects if e.name == "swelling")
    assert entry.parameters["amplitude"].value == pytest.approx(0.2, abs=0.02)
    rows = rows_of(data)
    left = rows.values - better.context(rows).base
    base = base_context(build_base(better.file, better.folder, rows), rows).base
    assert np.sqrt(np.mean(left**2)) < 0.15 < 0.3 < np.sqrt(np.mean((rows.values - base) ** 2))


def test_an_effect_beside_the_model_file_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A model takes its own folder's effects along, from wherever it is called."""
    place = tmp_path / "models"
    place.mkdir()
    write_template("swelling", place)
    (place / "model.yaml").write_text(
        "base: {kind: static}\n"
        "effects: [{name: swelling, form: simple, parameters: {amplitude: {value: 0.1}}}]\n"
    )
    assert "swelling" not in library()
    assert "swelling" in Model.load(place / "model.yaml").library()


def test_names_that_are_refused(labrig, tmp_path: Path) -> None:
    """No identifier, a name that labrig has, a file that exists: each is said, and nothing is written."""
    assert labrig("effects", "new", "My-Effect") == (
        2,
        "",
        "labrig: 'My-Effect': an effect's name is lower-case letters, digits and _, such as humidity\n",
    )
    assert labrig("effects", "new", "creep") == (
        2,
        "",
        "labrig: 'creep': labrig has an effect of this name; see: labrig effects show creep\n",
    )
    assert not Path("effects").exists()
    assert labrig("effects", "new", "swelling")[0] == 0
    file = tmp_path / "effects" / "swelling.py"
    file.write_text(file.read_text() + "# mine\n")
    assert labrig("effects", "new", "swelling") == (
        2,
        "",
        f"labrig: {file}: already exists; edit it, or choose another name\n",
    )
    assert file.read_text().endswith("# mine\n")


def test_files_that_are_no_effects(tmp_path: Path) -> None:
    """A file with a mistake is named with the mistake; an effect that does not say what it is, too."""

    def broken() -> str:
        return complaint(name="mine").removeprefix(
            "there is no effect 'mine', and an effect's file can't be read: "
        )

    folder = tmp_path / "effects"
    folder.mkdir()
    file = folder / "mine.py"
    file.write_text("import nothing_of_this_name\n")
    assert broken() == (f"{file}, line 1: ModuleNotFoundError: No module named 'nothing_of_this_name'")
    file.write_text("def f(:\n")
    assert broken() == f"{file}, line 1: is no Python (invalid syntax)"
    file.write_text(
        "from labrig.effects import Effect\n\n\nclass Mine(Effect):\n    name = 'mine'\n\n"
        "    def variants(self, context):\n        return iter(())\n"
    )
    assert broken() == f"{file}: the effect Mine does not say its 'meaning'"
    said = dict.fromkeys(("name", "meaning", "reference", "signature", "experiment"), "'of mine'")
    text = (
        "from labrig.effects import Effect, Parameter\n\n\nclass Mine(Effect):\n"
        + "".join(f"    {n} = {text}\n" for n, text in said.items())
        + "    acts_on = 'presure'\n    parameters = (Parameter('gain', '1', 'how much'),)\n\n"
        "    def variants(self, context):\n        return iter(())\n"
    )
    file.write_text(text)
    assert broken() == (
        f"{file}: the effect Mine: acts_on is 'presure'; there are pressure, mechanics and observation; "
        "did you mean pressure?"
    )
    file.write_text(text.replace("presure", "pressure"))
    assert broken() == f"{file}: the effect Mine: parameter 'gain': low, high and least are numbers"
    assert library()["mine.py"].signature == broken()
    file.rename(folder / "_mine.py")
    assert {"mine", "mine.py"}.isdisjoint(library())
