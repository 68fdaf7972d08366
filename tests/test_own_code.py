"""Files of people's own, and what they import from beside them."""

import sys
from pathlib import Path

import pandas as pd
import pytest

import labrig
from labrig import LabrigError
from labrig._own_code import load_module
from labrig.effects import library


def written(folder: Path, factor: float, *, package: bool = False) -> Path:
    """A folder with a model and the constant that it imports from a file, or from a package, beside it."""
    folder.mkdir(exist_ok=True)
    helper = folder / "constants_of_mine" / "__init__.py" if package else folder / "constants_of_mine.py"
    helper.parent.mkdir(exist_ok=True)
    helper.write_text(f"FACTOR = {factor}\n", encoding="utf-8")
    file = folder / "base.py"
    file.write_text(
        "import json\nimport wave\nfrom constants_of_mine import FACTOR\n\n\ndef predict(u):\n    return FACTOR * u\n",
        encoding="utf-8",
    )
    return file


def test_each_folder_has_its_own_helpers(tmp_path: Path) -> None:
    """Two models that import a file of one name get each its own, in either order, and so with a package."""
    for package in (False, True):
        files = [
            written(tmp_path / f"{name}{package}", k, package=package) for name, k in (("a", 0.8), ("b", 1.0))
        ]
        modules = [load_module(file, "labrig_user_base_base") for file in files]
        assert [module.predict(1.0) for module in modules] == [0.8, 1.0]
    assert "constants_of_mine" not in sys.modules
    assert "wave" in sys.modules


def test_a_helper_that_changed_is_read_again(tmp_path: Path) -> None:
    """A constant of as many letters that was changed within the same second counts, and nothing is left beside."""
    first = load_module(written(tmp_path, 0.8), "labrig_user_base_base")
    again = load_module(written(tmp_path, 0.9), "labrig_user_base_base")
    assert (first.predict(1.0), again.predict(1.0)) == (0.8, 0.9)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["base.py", "constants_of_mine.py"]


def test_what_a_notebook_imported_stays_its_own(tmp_path: Path, monkeypatch) -> None:
    """A module of that name that somebody imported before is neither taken for the helper nor lost to them."""
    written(tmp_path / "mine", 3.0)
    monkeypatch.syspath_prepend(tmp_path / "mine")
    import constants_of_mine  # type: ignore[import-not-found]

    monkeypatch.setitem(sys.modules, "constants_of_mine", constants_of_mine)
    module = load_module(written(tmp_path / "other", 0.5), "labrig_user_base_base")
    assert module.predict(1.0) == 0.5
    assert sys.modules["constants_of_mine"].FACTOR == 3.0


def test_a_file_that_ends_the_program_ends_nothing(tmp_path: Path) -> None:
    """A script that calls `sys.exit` when it is read is said with its line; labrig goes on."""
    file = tmp_path / "mine.py"
    file.write_text("import sys\n\nsys.exit(0)\n", encoding="utf-8")
    with pytest.raises(LabrigError) as caught:
        load_module(file, "labrig_user_base_mine")
    assert str(caught.value) == f"{file}, line 3: calls sys.exit"
    assert "labrig_user_base_mine" not in sys.modules
    file.write_text("import sys\nsys.exit('the licence has run out')\n", encoding="utf-8")
    with pytest.raises(LabrigError, match=r"line 2: calls sys\.exit: the licence has run out$"):
        load_module(file, "labrig_user_base_mine")


def test_a_function_that_ends_the_program_ends_nothing(tmp_path: Path) -> None:
    """A base whose library calls `sys.exit` is a base that failed."""

    def predict(_actuation: object) -> None:
        sys.exit(0)

    run = labrig.import_table(pd.DataFrame({"p_kPa": range(9), "x_mm": range(9)}), tmp_path / "mine")
    with pytest.raises(
        LabrigError, match=r"^the function predict failed on 9 rows of 1 chambers: SystemExit: 0$"
    ):
        labrig.compare(run, predict)


def test_an_effect_that_ends_the_program_is_left_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A script in `effects` that ends itself, read or asked, is said in the warnings."""
    effects = tmp_path / "effects"
    effects.mkdir()
    (effects / "helper.py").write_text("import sys\nsys.exit(0)\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert "helper.py, line 2: calls sys.exit" in library(tmp_path)["helper.py"].meaning
