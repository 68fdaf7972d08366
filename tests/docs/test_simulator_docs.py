"""The simulator's reference: its files are read, its code and its command run."""

import os
import re
import shlex
from pathlib import Path

from labrig.physics import load_surface, open_simulations
from labrig.rig import load_rig

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "simulator.md"


def test_the_page_does_what_it_says(labrig, tmp_path, monkeypatch):
    """Its shell file and rig file are read, its Python runs, and its command makes the set that it names."""
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"^```(\w*)\n(.*?)^```$", PAGE.read_text("utf-8"), re.MULTILINE | re.DOTALL)
    assert sorted(language for language, _ in blocks) == ["", "python", "yaml", "yaml"]
    for language, text in blocks:
        if language == "yaml":
            Path(text.splitlines()[0].removeprefix("# ")).write_text(text, encoding="utf-8")
        elif language == "python":
            exec(compile(text, str(PAGE), "exec"), {})
        else:
            code, out, err = labrig(*shlex.split(text)[1:])
            assert (code, err) == (0, "")
            assert "60 simulations of membrane" in out
    assert open_simulations("sims").jacobian is not None
    rig = load_rig("rig.yaml")
    surface = load_surface(rig.to_dict(), rig.folder)
    assert surface.chamber_names == ("left", "right")
    assert len(os.listdir("sims")) == 4  # noqa: PTH208
