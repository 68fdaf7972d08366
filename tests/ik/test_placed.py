"""A target of ik.json is placed beside the surface again, and is as far from it as the search said."""

import json

import numpy as np
import pytest
import yaml

from labrig.ik import placed, solve_files, write_solved
from labrig.surface import Mesh
from tests.ik.test_validate import PLAY
from tests.shapes import NEAR, write_lab


@pytest.fixture
def lab(tmp_path):
    return write_lab(tmp_path / "lab")


def entry_of(lab, target):
    """What ik.json says of a target."""
    write_solved(solve_files([lab / target], lab / "model.yaml"), "model.yaml", lab / "ik.json")
    return json.loads((lab / "ik.json").read_text())["targets"][0]


def mean_mm(entry, lab):
    """The mean distance of the picture."""
    return np.nanmean(np.abs(placed(entry, lab / "model.yaml", lab).signed_mm))


def test_the_distances_are_those_that_were_found(lab):
    """Of a target out of reach, to the digits of the file; the surface is the grid that was measured."""
    entry = entry_of(lab, "bodies/far.ply")
    assert mean_mm(entry, lab) == pytest.approx(entry["measured_mm"]["mean"], abs=1e-3)
    again = placed(entry, lab / "model.yaml", lab)
    assert len(again.surface_mm) == 61 * 61
    assert np.nanmean(again.signed_mm) == pytest.approx(entry["measured_mm"]["signed"], abs=1e-3)


def test_a_model_that_remembers_is_placed_after_its_path(lab):
    """Its last set-point alone would be another shape: what the path leaves counts."""
    (lab / "model.yaml").write_text(
        yaml.safe_dump({"base": {"kind": "simulator", "rig": "rig.yaml"}, "effects": [PLAY]})
    )
    entry = entry_of(lab, "near.ply")
    assert mean_mm(entry, lab) == pytest.approx(entry["measured_mm"]["mean"], abs=1e-3)
    assert np.abs(np.array(list(entry["pressure_kpa"].values())) - NEAR).max() > 1.0
    del entry["path"]
    assert mean_mm(entry, lab) > entry["measured_mm"]["mean"] + 0.1


def test_a_target_inside_out_keeps_its_signs(lab, monkeypatch):
    """What stands out of a target whose triangles face inwards still does."""
    from labrig.ik import _batch

    whole = _batch.read_mesh
    outwards = entry_of(lab, "bodies/far.ply")
    monkeypatch.setattr(_batch, "read_mesh", lambda *given: turned(whole(*given)))
    entry = entry_of(lab, "bodies/far.ply")
    assert (outwards["inverted"], entry["inverted"]) == (False, True)
    signed = np.nanmean(placed(entry, lab / "model.yaml", lab).signed_mm)
    assert signed == pytest.approx(outwards["measured_mm"]["signed"], abs=0.05)


def turned(mesh: Mesh) -> Mesh:
    return Mesh(mesh.vertices_mm, np.ascontiguousarray(mesh.triangles[:, ::-1]), mesh.notes)
