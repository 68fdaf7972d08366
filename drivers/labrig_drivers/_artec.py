"""The scanner, by way of the folder that Artec Studio exports into."""

import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml

from labrig_drivers._artec_files import (
    MM_PER_UNIT,
    IncompleteError,
    ScanFileError,
    declared_unit,
    parse,
    read_set,
    scan_set,
    weld,
)
from labrig_drivers._clock import Clock
from labrig_drivers._protocols import DeviceError, Identity, Scan

POLL_S = 0.05
MAX_ENTRIES = 20_000
UNCOUNTED = (".obj", ".xyz")  # these do not say how long they are: a pause in the writing looks like the end
UNCOUNTED_PATIENCE = 3.0


@dataclass(frozen=True)
class ArtecOptions:
    """The watched folder and the unit that is set in Artec Studio; times in s, sizes in mm.

    A set of files counts once nothing about it has changed for `settle_s` (three times that for OBJ and
    XYZ, which do not say how long they are); one that is still incomplete after `stall_s` without a
    change is an error. The bounding box's diagonal has to be within `size_mm`.
    """

    folder: Path
    unit: str
    formats: tuple[str, ...] = ("obj", "ply", "stl", "xyz")
    size_mm: tuple[float, float] = (50.0, 3000.0)
    settle_s: float = 1.0
    stall_s: float = 10.0


_Signature = tuple[int, int]  # bytes, mtime in ns


class ArtecFolder:
    """A `Scanner` whose operator exports each scan into a folder.

    What is there when it connects is never delivered; each later export is, once, in the order of the
    files' times; `skip_existing` before `scan` asks for one that begins now. A scan that comes in several
    formats counts once. `Scan.time_s` is when the export was last written to.
    """

    def __init__(self, name: str, clock: Clock, options: ArtecOptions) -> None:
        self.name = name
        self._clock = clock
        self._options = options
        self._seen: dict[Path, _Signature] = {}
        self._delivered: dict[str, tuple[Path, _Signature]] = {}
        self._changed: dict[Path, tuple[tuple[_Signature, ...], float]] = {}
        self._unfinished: set[Path] = set()
        self._connected = False

    def connect(self) -> None:
        """Begin to watch; `DeviceError` when the folder is not there."""
        if not self._options.folder.is_dir():
            raise DeviceError(
                f"{self.name}: the folder {self._options.folder} does not exist: create it, and export into it"
            )
        if not self._connected:
            self._connected = True
            self.skip_existing()

    def skip_existing(self) -> None:
        """Deliver nothing of what is in the folder now, nor what is being written: it shows the past."""
        listed = self._list()
        self._seen = dict(listed)
        self._changed.clear()
        recent_ns = (time.time() - self._options.settle_s) * 1e9
        self._unfinished = {path for path, signature in listed if signature[1] > recent_ns}

    def identify(self) -> Identity:
        """Where it watches, and what unit it takes the exports to be in."""
        options = self._options
        details = {
            "unit": options.unit,
            "formats": ", ".join(options.formats),
            "files there": str(len(self._list())),
        }
        return Identity(self.name, "artec", f"Artec Studio exports in {options.folder}", details)

    def scan(self, timeout_s: float = 120.0) -> Scan:
        """Wait for the next complete scan. One that fails a check is a `DeviceError`, and is not tried again."""
        if not self._connected:
            raise DeviceError(f"{self.name}: not connected")
        deadline = time.monotonic() + timeout_s
        waiting = ""
        while True:
            for mesh, signature in self._new():
                try:
                    scan = self._try(mesh)
                except IncompleteError as error:
                    waiting = f"; {error}"
                    continue
                except ScanFileError as error:
                    self._seen[mesh] = signature
                    raise DeviceError(f"{self.name}: {error}") from None
                if scan is not None:
                    self._seen[mesh] = signature
                    self._delivered[mesh.stem] = (mesh, signature)
                    return scan
                waiting = f"; {mesh.name} has {signature[0]} bytes and is still changing"
            if time.monotonic() >= deadline:
                raise DeviceError(
                    f"{self.name}: no complete scan in {self._options.folder} within {timeout_s:g} s{waiting}"
                )
            time.sleep(POLL_S)

    def close(self) -> None:
        """Stop watching; never raises."""
        self._connected = False

    def _list(self) -> list[tuple[Path, _Signature]]:
        suffixes = {f".{kind}" for kind in self._options.formats}
        found: list[tuple[Path, _Signature]] = []
        try:
            for count, path in enumerate(self._options.folder.iterdir()):
                if count >= MAX_ENTRIES:
                    raise DeviceError(
                        f"{self.name}: more than {MAX_ENTRIES} files in {self._options.folder}: clear it out"
                    )
                if path.suffix.lower() in suffixes and path.is_file():
                    found.append((path, _signature(path)))
        except OSError as error:
            raise DeviceError(
                f"{self.name}: cannot look into {self._options.folder}: {error.strerror}"
            ) from None
        return sorted(found, key=lambda entry: (entry[1][1], entry[0].name))

    def _new(self) -> list[tuple[Path, _Signature]]:
        new: list[tuple[Path, _Signature]] = []
        for path, signature in self._list():
            if path in self._unfinished:
                if self._quiet_s(path, (path,)) >= self._options.settle_s:
                    self._unfinished.discard(path)
                self._seen[path] = signature
                continue
            if self._seen.get(path) == signature:
                continue
            delivered = self._delivered.get(path.stem)
            if delivered is not None and delivered[0] != path:
                same, known = delivered
                if same.is_file() and _signature(same) == known:  # the same scan in a second format
                    self._seen[path] = signature
                    continue
            new.append((path, signature))
        return new

    def _try(self, mesh: Path) -> Scan | None:
        """The scan, or None while it is changing; `IncompleteError` while it may still be completed."""
        try:
            files, problem = scan_set(mesh), None
        except IncompleteError as error:
            files, problem = (mesh,), error
        except OSError as error:
            raise IncompleteError(f"{mesh.name}: {error.strerror}") from None
        quiet_s = self._quiet_s(mesh, files)
        uncounted = mesh.suffix.lower() in UNCOUNTED
        if quiet_s < self._options.settle_s * (UNCOUNTED_PATIENCE if uncounted else 1.0):
            return None
        try:
            if problem is not None:
                raise problem
            return self._read(mesh, files)
        except IncompleteError as error:
            if quiet_s < self._options.stall_s:
                raise
            raise ScanFileError(
                f"{error}, and nothing has been written for {quiet_s:.0f} s: export it again"
            ) from None

    def _quiet_s(self, mesh: Path, files: tuple[Path, ...]) -> float:
        signatures = tuple(_signature(file) for file in files)
        known = self._changed.get(mesh)
        now = time.monotonic()
        if known is None or known[0] != signatures:
            self._changed[mesh] = (signatures, now)
            return 0.0
        return now - known[1]

    def _read(self, mesh: Path, files: tuple[Path, ...]) -> Scan:
        before = tuple(_signature(file) for file in files)
        try:
            data, sha256 = read_set(files)
        except OSError as error:
            raise IncompleteError(f"{mesh.name}: {error.strerror}") from None
        if tuple(_signature(file) for file in files) != before:
            raise IncompleteError(f"{mesh.name} changed while it was read")
        geometry = parse(data, mesh.name)
        said = declared_unit(data)
        if said not in (None, self._options.unit):
            raise ScanFileError(
                f"{mesh.name} says that its unit is {said}, and the rig file says {self._options.unit}: correct one"
            )
        vertices_mm = geometry.vertices * MM_PER_UNIT[self._options.unit]
        self._check_size(vertices_mm, mesh)
        welded = weld(vertices_mm, geometry.triangles)
        if len(geometry.triangles) and len(welded.triangles) == 0:
            raise ScanFileError(f"{mesh.name} has no triangle with an area")
        return Scan(
            max(signature[1] for signature in before) / 1e9,
            welded.vertices,
            welded.triangles,
            files,
            sha256,
            _registration_error_mm(mesh),
            self._options.unit,
        )

    def _check_size(self, vertices_mm: np.ndarray, mesh: Path) -> None:
        extent = vertices_mm.max(axis=0) - vertices_mm.min(axis=0)
        diagonal_mm = float(np.linalg.norm(extent))
        low, high = self._options.size_mm
        if low <= diagonal_mm <= high:
            return
        in_unit = diagonal_mm / MM_PER_UNIT[self._options.unit]
        fitting = [unit for unit, scale in MM_PER_UNIT.items() if low <= in_unit * scale <= high]
        hint = f"exported in {' or '.join(fitting)}?" if fitting else "is that the right object?"
        raise ScanFileError(
            f"{mesh.name} is {diagonal_mm:.4g} mm across if its unit is {self._options.unit}, which is not "
            f"within {low:g} to {high:g} mm: {hint}"
        )


def _signature(path: Path) -> _Signature:
    try:
        stat = path.stat()
    except OSError:
        return (-1, 0)
    return (stat.st_size, stat.st_mtime_ns)


def _registration_error_mm(mesh: Path) -> float | None:
    """What a person wrote down beside the scan: NAME.yaml with `registration_error_mm`."""
    note = mesh.with_suffix(".yaml")
    if not note.is_file():
        return None
    try:
        value = yaml.safe_load(note.read_text(encoding="utf-8"))["registration_error_mm"]
        return float(value)
    except (OSError, UnicodeDecodeError, yaml.YAMLError, KeyError, TypeError, ValueError):
        raise ScanFileError(f"{note.name} does not say `registration_error_mm: NUMBER`") from None
