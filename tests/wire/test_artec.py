"""The watched folder: what counts as a scan, and what is refused with a reason."""

import hashlib
import threading
import time

import numpy as np
import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, rule

from labrig_drivers import DeviceError, RealClock, build_device
from labrig_drivers._artec_files import IncompleteError, ScanFileError, parse, weld
from labrig_drivers.simulated._artec_twin import (
    ArtecTwin,
    obj_bytes,
    ply_bytes,
    png_bytes,
    stl_bytes,
    xyz_bytes,
)

TRIANGLES = np.array([[0, 1, 2], [1, 3, 2]])
SQUARE = np.array([[0.0, 0, 0], [100, 0, 0], [0, 100, 0], [100, 100, 10]])


@pytest.fixture
def scanner(tmp_path):
    """Makes a connected scanner on a new folder: `scanner(**settings)`."""

    def make(folder="scans", **more):
        (tmp_path / folder).mkdir(exist_ok=True)
        options = {"folder": folder, "unit": "mm", "settle_s": 0.1, "stall_s": 0.3, **more}
        device = build_device("artec", options, name="scanner", clock=RealClock(), base=tmp_path)
        device.connect()
        return device

    return make


@pytest.fixture
def operator(shared, tmp_path):
    """An operator who exports in the background: `operator(**settings)` returns when it has begun."""
    threads = []

    def export(**settings):
        twin = ArtecTwin(shared, tmp_path / "scans", **{"bytes_per_s": 200e3, **settings}).start()
        threads.append(threading.Thread(target=twin.export))
        threads[-1].start()
        return twin

    yield export
    for thread in threads:
        thread.join()


@pytest.mark.parametrize("kind", ["obj", "ply", "stl", "xyz"])
@pytest.mark.parametrize("unit", ["mm", "m", "inch"])
def test_exports_arrive_whole_in_mm(scanner, operator, shared, kind, unit):
    """A set written slowly and in place is delivered once it is complete, in mm, welded."""
    device = scanner(unit=unit)
    operator(formats=(kind,), unit=unit, noise_mm=0.0, seams=True)
    scan = device.scan(timeout_s=20)
    vertices_mm, triangles = shared.surface()
    assert scan.vertices_mm.shape == vertices_mm.shape
    np.testing.assert_allclose(np.sort(scan.vertices_mm, 0), np.sort(vertices_mm, 0), atol=2e-2)
    assert len(scan.triangles) == (0 if kind == "xyz" else len(triangles))
    suffixes = [".obj", ".mtl", ".png"] if kind == "obj" else [f".{kind}"]
    assert [path.name for path in scan.files] == [f"Eva scan 1{suffix}" for suffix in suffixes]


def test_the_hash_covers_the_whole_set(scanner, operator):
    """The hash is that of names, lengths and bytes of all files of the set, in order of name."""
    device = scanner()
    operator()
    scan = device.scan(timeout_s=20)
    digest = hashlib.sha256()
    for path in sorted(scan.files):
        data = path.read_bytes()
        digest.update(f"{path.name}\0{len(data)}\0".encode() + data)
    assert scan.sha256 == digest.hexdigest()
    assert scan.time_s == max(path.stat().st_mtime_ns for path in scan.files) / 1e9


def test_registration_error_is_taken_from_the_note(scanner, operator):
    """A note beside the scan says how well its frames fitted."""
    device = scanner()
    operator(registration_error_mm=0.4)
    assert device.scan(timeout_s=20).registration_error_mm == 0.4


@pytest.mark.parametrize(
    ("kind", "part", "text"),
    [
        ("ply", 0.5, "promises at least 4874 bytes after its header and has"),
        ("ply", 0.98, "promises at least 4874 bytes after its header and has"),
        ("ply", 0.02, "has no complete PLY header"),
        ("stl", 0.5, "is not as long as its STL header promises"),
        ("obj", 0.981, "ends in the middle of a line: it was cut off, or has no line break at its end"),
        ("xyz", 0.503, "ends in the middle of a line"),
    ],
)
def test_truncated_exports_are_refused(scanner, operator, kind, part, text):
    """A file that was cut is never a scan: after it has stalled the error says what is missing."""
    device = scanner()
    operator(formats=(kind,), truncate=part, bytes_per_s=1e6)
    with pytest.raises(DeviceError) as error:
        device.scan(timeout_s=20)
    assert str(error.value).startswith(f"scanner: Eva scan 1.{kind} {text}")
    assert str(error.value).endswith("nothing has been written for 0 s: export it again")


def put(folder, name, data):
    """Write a file at once."""
    (folder / name).write_bytes(data)


def test_an_obj_waits_for_its_material_and_texture(scanner, tmp_path):
    """An OBJ whose MTL or texture is missing or cut is not a scan yet."""
    device = scanner(stall_s=60)
    folder = tmp_path / "scans"
    put(folder, "a.obj", obj_bytes(SQUARE, TRIANGLES, "a.mtl", False))
    with pytest.raises(DeviceError, match=r"within 0\.3 s; a\.obj needs a\.mtl, which is not there$"):
        device.scan(timeout_s=0.3)
    put(folder, "a.mtl", b"newmtl m\nmap_Kd my picture.png\n")
    with pytest.raises(DeviceError, match=r"; a\.obj needs my picture\.png, which is not there$"):
        device.scan(timeout_s=0.3)
    put(folder, "my picture.png", png_bytes(4, 4)[:-3])
    with pytest.raises(DeviceError, match=r"; my picture\.png is cut short \(\d+ bytes\)$"):
        device.scan(timeout_s=0.3)
    put(folder, "my picture.png", png_bytes(4, 4))
    assert len(device.scan(timeout_s=5).files) == 3


def test_a_file_that_still_changes_is_not_read(scanner, tmp_path):
    """As long as something is written nothing is delivered, though it would already pass."""
    device = scanner(settle_s=0.4)
    path = tmp_path / "scans" / "a.xyz"
    stop = threading.Event()

    def write():
        with path.open("wb") as file:
            while not stop.wait(0.02):
                file.write(b"1.0 2.0 3.0\n" * 10)
                file.flush()

    thread = threading.Thread(target=write)
    thread.start()
    try:
        with pytest.raises(DeviceError, match=r"within 1 s; a\.xyz has \d+ bytes and is still changing$"):
            device.scan(timeout_s=1.0)
    finally:
        stop.set()
        thread.join()


def test_what_was_there_before_is_no_new_scan(scanner, tmp_path):
    """Files from before the connection are not delivered; the same file exported again is, once."""
    folder = tmp_path / "scans"
    folder.mkdir()
    put(folder, "old.ply", ply_bytes(SQUARE, TRIANGLES))
    device = scanner()
    with pytest.raises(DeviceError) as error:
        device.scan(timeout_s=0.3)
    assert str(error.value) == f"scanner: no complete scan in {folder} within 0.3 s"
    put(folder, "old.ply", ply_bytes(SQUARE * 2, TRIANGLES))
    assert device.scan(timeout_s=5).vertices_mm.max() == 200
    with pytest.raises(DeviceError, match="no complete scan"):
        device.scan(timeout_s=0.3)


def test_skipping_what_is_there_and_what_is_being_written(scanner, tmp_path):
    """After `skip_existing` neither an earlier export nor the rest of one under way is delivered."""
    device = scanner(settle_s=0.3)
    folder = tmp_path / "scans"
    put(folder, "before.ply", ply_bytes(SQUARE, TRIANGLES))
    data = ply_bytes(SQUARE, TRIANGLES)
    put(folder, "under way.ply", data[:200])
    device.skip_existing()
    put(folder, "under way.ply", data)
    with pytest.raises(DeviceError, match="no complete scan"):
        device.scan(timeout_s=1.0)
    put(folder, "after.ply", data)
    assert device.scan(timeout_s=5).files[0].name == "after.ply"


def test_an_operator_who_clears_away(shared, tmp_path):
    """The twin that exports again and again keeps only the last ones."""
    twin = ArtecTwin(shared, tmp_path, keep=2, bytes_per_s=1e9).start()
    for _ in range(4):
        twin.export()
    assert sorted(path.name for path in tmp_path.glob("*.obj")) == ["Eva scan 3.obj", "Eva scan 4.obj"]
    assert len(list(tmp_path.iterdir())) == 6


def test_one_scan_in_several_formats_counts_once(scanner, tmp_path):
    """Exports of one name in several formats are one scan; the next name is the next."""
    device = scanner()
    folder = tmp_path / "scans"
    put(folder, "Eva scan 1.ply", ply_bytes(SQUARE, TRIANGLES))
    first = device.scan(timeout_s=5)
    put(folder, "Eva scan 1.stl", stl_bytes(SQUARE, TRIANGLES))
    put(folder, "Eva scan 2.stl", stl_bytes(SQUARE, TRIANGLES))
    second = device.scan(timeout_s=5)
    assert [scan.files[0].name for scan in (first, second)] == ["Eva scan 1.ply", "Eva scan 2.stl"]


def test_a_wrong_unit_is_noticed(scanner, tmp_path):
    """A bounding box that makes no sense in the declared unit is refused, with the unit that would."""
    device = scanner(unit="mm")
    put(tmp_path / "scans", "a.ply", ply_bytes(SQUARE / 1000, TRIANGLES))
    with pytest.raises(DeviceError) as error:
        device.scan(timeout_s=5)
    assert str(error.value) == (
        "scanner: a.ply is 0.1418 mm across if its unit is mm, which is not within 50 to 3000 mm: exported in m?"
    )
    with pytest.raises(DeviceError, match="no complete scan"):  # it is not tried again
        device.scan(timeout_s=0.2)


@pytest.mark.parametrize("comment", ["unit cm", "Units: centimeters"])
def test_a_file_that_says_another_unit_is_refused(scanner, tmp_path, comment):
    """A PLY that names its unit is not read as the rig file's other one, also where the size would do."""
    device = scanner(unit="mm")
    data = ply_bytes(SQUARE, TRIANGLES).replace(b"1.0\n", f"1.0\ncomment {comment}\n".encode(), 1)
    put(tmp_path / "scans", "a.ply", data)
    with pytest.raises(DeviceError) as error:
        device.scan(timeout_s=5)
    said = "scanner: a.ply says that its unit is cm, and the rig file says mm: correct one"
    assert str(error.value) == said


def test_a_missing_folder(tmp_path):
    """A folder that is not there is named at connect."""
    options = {"folder": "nowhere", "unit": "mm"}
    device = build_device("artec", options, name="scanner", clock=RealClock(), base=tmp_path)
    with pytest.raises(DeviceError) as error:
        device.connect()
    assert str(error.value) == (
        f"scanner: the folder {tmp_path / 'nowhere'} does not exist: create it, and export into it"
    )


def test_the_unit_has_to_be_declared():
    """There is no default unit."""
    with pytest.raises(DeviceError) as error:
        build_device("artec", {"folder": "x"}, name="scanner", clock=RealClock())
    assert str(error.value) == "scanner: unit: Field required"


OBJ = "v 0 0 0\nv 100 0 0\nv 0 100 0\n"
ASCII_PLY = (
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n"
)


@pytest.mark.parametrize(
    ("name", "data", "text"),
    [
        ("a.obj", OBJ + "v nan 0 0\nf 1 2 3\n", "a.obj has a vertex that is no number"),
        ("a.obj", OBJ + "f 1 2 0\n", "a.obj has a face with an index below 1"),
        ("a.obj", OBJ + "f 1 2 -1\n", "a.obj has a face with an index below 1"),
        (
            "a.obj",
            "o a\n" + OBJ + "f 1 2 3\no b\nf 1 3 2\n",
            "a.obj holds several objects (a, b): export one scan to a file",
        ),
        ("a.obj", OBJ, "a.obj has 3 vertices and no faces"),
        ("a.obj", "# Faces: 2\n" + OBJ + "f 1 2 3\n", "a.obj promises 2 faces and has 1"),
        ("a.ply", ASCII_PLY + "3 0 1 7\n", "a.ply has a face with a vertex that does not exist (of 3)"),
        ("a.ply", ASCII_PLY, "a.ply promises 4 lines and has 3, or its last one is cut"),
        (
            "a.ply",
            ASCII_PLY.replace("vertex 3", "vertex 999999999999") + "3 0 1 2\n",
            "a.ply promises 999999999999 elements, more than any scan has",
        ),
        (
            "a.ply",
            ASCII_PLY.replace("float z", "quad z") + "3 0 1 2\n",
            "a.ply has a property that is not understood: 'property quad z'",
        ),
        ("a.xyz", "1 2 nan\n", "a.xyz has 1 coordinates that are no numbers"),
        ("a.xyz", "1 2\n", "a.xyz is not a list of x y z: invalid column index 2 at row 1 with 2 columns"),
        ("a.stl", "solid a\nfacet normal 0 0 1\n", "a.stl has no endsolid line"),
        ("a.wrl", "#VRML", "a.wrl: not a format that is read (OBJ, PLY, STL, XYZ)"),
    ],
)
def test_damage_that_a_library_passes_is_refused(name, data, text):
    """NaN, bad indices, missing faces, several objects: each is refused by name."""
    with pytest.raises(ScanFileError) as error:
        parse(data.encode(), name)
    assert str(error.value) == text


@pytest.mark.parametrize("name", ["a.obj", "a.ply", "a.stl", "a.xyz"])
def test_every_cut_of_every_format_is_refused_or_whole(name):
    """No matter where a file is cut, what comes out has all its triangles, or nothing comes out."""
    write = {
        "a.obj": lambda: obj_bytes(SQUARE, TRIANGLES, "a.mtl", True),
        "a.ply": lambda: ply_bytes(SQUARE, TRIANGLES),
        "a.stl": lambda: stl_bytes(SQUARE, TRIANGLES),
        "a.xyz": lambda: xyz_bytes(SQUARE, TRIANGLES),
    }[name]
    data = write()
    whole = parse(data, name)
    assert len(whole.triangles) == (0 if name == "a.xyz" else 2)
    for cut in range(len(data)):
        try:
            geometry = parse(data[:cut], name)
        except ScanFileError:
            continue
        # Formats of lines without counts cannot tell a cut between two lines; the watcher waits those out.
        assert data[:cut].endswith(b"\n")
        assert name in ("a.obj", "a.xyz")
        assert len(geometry.vertices) <= len(whole.vertices)


def test_a_half_written_file_is_incomplete_not_wrong():
    """What may still be completed is told apart from what never can be."""
    with pytest.raises(IncompleteError):
        parse(ply_bytes(SQUARE, TRIANGLES)[:-1], "a.ply")


def test_seams_are_welded():
    """A surface split along its texture's seams is one surface again; collapsed triangles go."""
    doubled = np.concatenate([SQUARE, SQUARE])
    triangles = np.concatenate([TRIANGLES, [[4, 5, 6]], [[0, 4, 1]]])
    welded = weld(doubled, triangles)
    np.testing.assert_array_equal(welded.vertices, SQUARE)
    assert welded.triangles.tolist() == [*TRIANGLES.tolist(), [0, 1, 2]]


class FolderMachine(RuleBasedStateMachine):
    """Exports whole, cut or of another kind, in any order: only whole ones come out, each once, in order."""

    @initialize(folder=st.just(None))
    def start(self, folder):
        import tempfile
        from pathlib import Path

        self.directory = tempfile.TemporaryDirectory()
        self.folder = Path(self.directory.name)
        options = {"folder": str(self.folder), "unit": "mm", "settle_s": 0.02, "stall_s": 0.06}
        self.device = build_device("artec", options, name="scanner", clock=RealClock())
        self.device.connect()
        self.number = 0
        self.expected = []

    def export(self, kind, part):
        self.number += 1
        data = (ply_bytes if kind == "ply" else stl_bytes)(SQUARE, TRIANGLES)
        put(self.folder, f"Eva scan {self.number}.{kind}", data[: int(len(data) * part)])
        time.sleep(0.002)  # the order of the files' times

    @rule(kind=st.sampled_from(["ply", "stl"]))
    def export_whole(self, kind):
        self.export(kind, 1.0)
        self.expected.append(f"Eva scan {self.number}.{kind}")

    @rule(kind=st.sampled_from(["ply", "stl"]), part=st.floats(0.1, 0.99))
    def export_cut(self, kind, part):
        self.export(kind, part)
        self.expected.append(None)

    @rule()
    def something_else(self):
        put(self.folder, f"notes {self.number}.txt", b"hello")

    @rule()
    def scan(self):
        if not self.expected:
            with pytest.raises(DeviceError, match="no complete scan"):
                self.device.scan(timeout_s=0.0)
            return
        whole = [name for name in self.expected if name is not None]
        if whole:
            seen = []
            for _ in self.expected:
                try:
                    seen.append(self.device.scan(timeout_s=2).files[0].name)
                except DeviceError as error:
                    seen.append(None)
                    self.expected_cut(error)
            assert sorted(map(str, seen)) == sorted(map(str, self.expected))
            assert [name for name in seen if name] == whole
            self.expected = []

    @staticmethod
    def expected_cut(error):
        assert "export it again" in str(error) or "no complete PLY header" in str(error)

    def teardown(self):
        if hasattr(self, "directory"):
            self.directory.cleanup()


TestFolderMachine = FolderMachine.TestCase
TestFolderMachine.settings = settings(max_examples=12, stateful_step_count=10)
