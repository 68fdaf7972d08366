"""Files of learned models: exact, small to trust, and refused in one line when they are not whole."""

import json
import zipfile

import numpy as np
import pytest

from labrig import LabrigError
from labrig.surface import grid
from labrig.surrogate import load_forward, load_model, save_model, train_forward
from labrig.surrogate._torch_training import Recipe

SMALL = Recipe((16, 16), "gelu", epochs=10, batch=16, rate=5e-3)


@pytest.fixture(scope="module")
def model(data):
    """A forward model."""
    return train_forward(data, samples=6).model


@pytest.fixture
def path(model, tmp_path):
    """Its file."""
    save_model(model, tmp_path / "forward.pt")
    return tmp_path / "forward.pt"


@pytest.mark.parametrize("method", ["gaussian", "network", "paper"])
def test_round_trip(method, data, tmp_path):
    """A loaded model predicts the same bits, and knows where it comes from."""
    model = train_forward(data, method, recipe=None if method == "gaussian" else SMALL, samples=6).model
    save_model(model, tmp_path / "a.pt")
    loaded = load_forward(tmp_path / "a.pt")
    uv, _ = grid(5, 5)
    a = np.array([[10.0, 20.0, 60.0]])
    for name in ("points", "jacobian", "sd_mm"):
        assert np.array_equal(getattr(loaded, name)(a, uv), getattr(model, name)(a, uv))
    assert loaded.provenance == model.provenance
    assert loaded.provenance["settings"]["method"] == method
    assert loaded.marker_names == model.marker_names


def test_equal_models_are_equal_files(model, path, tmp_path):
    """Nothing in a file depends on when or where it was written."""
    save_model(model, tmp_path / "again.pt")
    assert (tmp_path / "again.pt").read_bytes() == path.read_bytes()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["again.pt", "forward.pt"]


def _rewrite(path, change):
    """Write the file again with its entries as `change` makes them of (name, bytes)."""
    with zipfile.ZipFile(path) as archive:
        entries = {name: archive.read(name) for name in archive.namelist()}
    change(entries)
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in entries.items():
            archive.writestr(name, content)


def _facts(entries, **changes):
    entries["facts.json"] = json.dumps(json.loads(entries["facts.json"]) | changes).encode()


def test_newer_format(path):
    """A file of a newer labrig is named as such."""
    _rewrite(path, lambda e: _facts(e, version=3))
    with pytest.raises(LabrigError) as caught:
        load_model(path)
    assert str(caught.value) == (
        f"{path}: was written by a newer labrig (format 3, this one reads 2); update labrig"
    )


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda e: e.pop("facts.json"), "is not a learned model of labrig's (it has no facts.json)"),
        (lambda e: _facts(e, format="other"), "is not a learned model of labrig's"),
        (lambda e: _facts(e, version=None), "is damaged (its version is None)"),
        (lambda e: _facts(e, kind="tree"), "is damaged (there is no model of kind 'tree')"),
        (lambda e: e.pop("mean_mm.npy"), "is damaged (mean_mm is missing or holds no numbers)"),
    ],
)
def test_what_is_wrong_is_said(path, change, message):
    """What is missing in a file, or foreign, is said in one line."""
    _rewrite(path, change)
    with pytest.raises(LabrigError) as caught:
        load_model(path)
    assert str(caught.value) == f"{path}: {message}"


def test_pickles_are_not_loaded(path):
    """An array of objects, which could run code, is refused."""

    def change(entries):
        import io

        buffer = io.BytesIO()
        np.lib.format.write_array(buffer, np.array([{}], dtype=object), allow_pickle=True)
        entries["mean_mm.npy"] = buffer.getvalue()

    _rewrite(path, change)
    with pytest.raises(LabrigError, match="is damaged"):
        load_model(path)


@pytest.mark.parametrize(("flag", "method"), [(1, None), (0, 99)])
def test_encrypted_and_strangely_packed_files(path, flag, method):
    """An entry that is encrypted, or packed in a way that nobody knows, is one line as any other damage."""
    whole = bytearray(path.read_bytes())
    for signature, where in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        start = whole.index(signature) + where
        whole[start] |= flag
        whole[start + 2] = whole[start + 2] if method is None else method
    path.write_bytes(whole)
    with pytest.raises(LabrigError, match="is damaged"):
        load_forward(path)


def test_foreign_and_missing_files(tmp_path):
    """A file of another kind, and one that is not there, are named."""
    other = tmp_path / "x.pt"
    other.write_bytes(b"not a zip")
    with pytest.raises(LabrigError) as caught:
        load_model(other)
    assert str(caught.value) == (
        f"{other}: is not a learned model of labrig's (File is not a zip file); such a model is a file that labrig "
        "train writes, forward.pt or sim2real.pt"
    )
    with pytest.raises(LabrigError) as caught:
        load_model(tmp_path / "none.pt")
    assert str(caught.value) == f"{tmp_path / 'none.pt'}: does not exist; make it with: labrig train"


def test_any_damage_is_found(path):
    """A byte that changed anywhere is either without effect or an error of one line, never a wrong model."""
    whole = path.read_bytes()
    model = load_forward(path)
    rng = np.random.default_rng(0)
    uv, _ = grid(3, 3)
    expected = model.points(np.full(3, 30.0), uv)
    refused = []
    for place in rng.integers(0, len(whole), 60):
        damaged = bytearray(whole)
        damaged[place] ^= 1 << int(rng.integers(8))
        path.write_bytes(damaged)
        try:
            assert np.array_equal(load_forward(path).points(np.full(3, 30.0), uv), expected)
        except LabrigError as error:
            refused.append(str(error))
    assert len(refused) > 40
    assert not any("\n" in text for text in refused)
