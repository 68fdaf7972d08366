"""The base that was learned: it predicts a run's markers by name, with the model's own derivative."""

from pathlib import Path

import numpy as np
import pytest

from labrig._errors import LabrigError
from labrig.effects import Rows, rows_of
from labrig.log._dataset import CampaignArrays, to_dataset
from labrig.log._layout import Layout
from labrig.model import Model, build_base, jacobian
from labrig.surface import Spline
from labrig.surrogate import TrainingSet, save_model, train_forward

PRESSURE = np.random.default_rng(0).random((30, 2)) * 60.0


def _rows(model, markers: tuple[str, ...], chambers: tuple[str, ...]) -> Rows:
    """A campaign of ten captures of what the model itself predicts, in the given order of names."""
    order = [model.chamber_names.index(c) for c in chambers]
    position = model.points(PRESSURE[:10], model.markers(("m1", "m2", "m3")))
    place = {"m1": 0, "m2": 1, "m3": 2}
    layout = Layout(
        source="rig", chambers=chambers, chamber_min=(0.0, 0.0), chamber_max=(60.0, 60.0), markers=markers,
        unit="kPa", session="1", start_s=0.0,
    )  # fmt: skip
    arrays = CampaignArrays(
        commanded=PRESSURE[:10][:, order],
        hold_s=np.full((10, 1), 3.0),
        time_s=np.arange(10.0)[:, None] * 4,
        settled=np.ones((10, 1), bool),
        event_time_s=np.arange(10.0) * 4,
        event_commanded=PRESSURE[:10][:, order],
        session=["1"] * 10,
        repeat=[""] * 10,
        event_session=["1"] * 10,
        event_of=np.arange(10),
        position_mm=position[:, None][:, :, [place.get(m, 0) for m in markers]],
    )
    return rows_of(to_dataset(arrays, layout, {"run": "test"}))


@pytest.fixture(scope="module")
def model():
    """A forward model of a small sheet with three markers."""
    spline = Spline((6, 6), 2)
    u, v = np.meshgrid(*spline.greville, indexing="ij")
    rest = np.stack([100 * u, 0 * u, 100 * v], axis=-1)
    control = np.tile(rest, (30, 1, 1, 1))
    control[..., 1] += np.einsum("fc,cij->fij", PRESSURE, np.stack([u * (1 - u), v * (1 - v) * u]))
    uv = np.array([[0.3, 0.4], [0.6, 0.5], [0.5, 0.8]])
    data = TrainingSet(
        ("c1", "c2"), np.zeros(2), np.full(2, 60.0), spline, PRESSURE, control, None, ("m1", "m2", "m3"), uv
    )
    return train_forward(data, samples=5).model


@pytest.fixture
def folder(model, tmp_path: Path) -> Path:
    """A folder with the model's file and a model.yaml that names it."""
    save_model(model, tmp_path / "forward.pt")
    (tmp_path / "model.yaml").write_text("base: {kind: surrogate, file: forward.pt}\n")
    return tmp_path


def test_markers_and_chambers_by_name(model, folder):
    """Markers and chambers may come in any order and number; each is found by its name."""
    rows = _rows(model, ("m3", "m1"), ("c2", "c1"))
    loaded = Model.load(folder / "model.yaml")
    base = build_base(loaded.file, loaded.folder, rows)
    assert np.allclose(base.predict(rows.actuation), rows.values, atol=1e-9)
    assert base.declared(rows.actuation) is None


def test_derivative(model, folder):
    """The derivative by the run's chambers is the model's, in their order."""
    rows = _rows(model, ("m2",), ("c2", "c1"))
    loaded = Model.load(folder / "model.yaml")
    base = build_base(loaded.file, loaded.folder, rows)
    J = jacobian(base, rows.actuation, rows.low, rows.high)
    for c in range(2):
        step = 1e-3 * np.eye(2)[c]
        numeric = (base.predict(rows.actuation + step) - base.predict(rows.actuation - step)) / 2e-3
        assert np.allclose(J[..., c], numeric, atol=1e-6)


def test_saved_elsewhere(model, folder, tmp_path):
    """A model that is saved in another folder still finds its file."""
    (tmp_path / "deeper").mkdir()
    Model.load(folder / "model.yaml").save(tmp_path / "deeper" / "model.yaml")
    loaded = Model.load(tmp_path / "deeper" / "model.yaml")
    rows = _rows(model, ("m1",), ("c1", "c2"))
    assert build_base(loaded.file, loaded.folder, rows).kind == "surrogate"


@pytest.mark.parametrize(
    ("markers", "chambers", "complaint"),
    [
        (("m9",), ("c1", "c2"), "the learned model knows nothing of marker 'm9', which the run has"),
        (("m1",), ("c1", "c3"), "its chambers (c1, c2) are not the run's (c1, c3)"),
    ],
)
def test_names_that_do_not_fit(markers, chambers, complaint, model, folder):
    """Markers and chambers that the model does not know are named."""
    known = _rows(model, markers, ("c1", "c2"))
    rows = Rows(**{**{f: getattr(known, f) for f in known.__dataclass_fields__}, "chambers": chambers})
    loaded = Model.load(folder / "model.yaml")
    with pytest.raises(LabrigError) as caught:
        build_base(loaded.file, loaded.folder, rows)
    assert str(caught.value) == f"{folder / 'forward.pt'}: {complaint}"
