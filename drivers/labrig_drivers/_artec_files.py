"""Exported scan files: which belong together, whether they are all there, and what they hold.

A library reads the geometry; it does not notice most damage, so everything is checked here first (what
the headers promise against the bytes that are there) and afterwards (what was read against the headers).
"""

import hashlib
import io
import logging
import re
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

MM_PER_UNIT = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "inch": 25.4}
MAX_FILE_BYTES = 4 << 30
MAX_HEADER_BYTES = 1 << 16
MAX_ELEMENTS = 100_000_000
_UNIT_WORDS = {
    **{unit: unit for unit in MM_PER_UNIT},
    **{
        f"{part}met{end}": unit
        for part, unit in (("milli", "mm"), ("centi", "cm"), ("", "m"))
        for end in ("er", "re")
    },
    "in": "inch",
    "inche": "inch",
}
"""What a file may call its unit, without the s of several."""
WELD_MM = 1e-4

# What the library would print about damaged bytes is in our errors already.
logging.getLogger("trimesh").addHandler(logging.NullHandler())

_PLY_BYTES = {
    **dict.fromkeys(("char", "uchar", "int8", "uint8"), 1),
    **dict.fromkeys(("short", "ushort", "int16", "uint16"), 2),
    **dict.fromkeys(("int", "uint", "float", "int32", "uint32", "float32"), 4),
    **dict.fromkeys(("double", "float64", "int64", "uint64"), 8),
}


class ScanFileError(ValueError):
    """A scan file cannot be used; the message names it and says why."""


class IncompleteError(ScanFileError):
    """A scan file ends too early, or one that belongs to it is not there yet: it may still be written."""


@dataclass(frozen=True)
class Geometry:
    """What a file holds, in its own unit: vertices (V, 3), triangles (T, 3); T = 0 for a cloud."""

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int64]


def scan_set(mesh: Path) -> tuple[Path, ...]:
    """The files of a scan: the mesh, and for an OBJ its MTL files and textures. `IncompleteError`."""
    if mesh.suffix.lower() != ".obj":
        return (mesh,)
    files = [mesh]
    for name in _names(mesh, rb"^mtllib[ \t]+(.+?)[ \t]*\r?$"):
        material = mesh.parent / name
        _must_exist(material, mesh)
        files.append(material)
        for entry in _names(material, rb"^[ \t]*(?:map_\w+|bump|disp|decal)[ \t]+(.+?)[ \t]*\r?$"):
            # Artec's names hold blanks; only an entry with options is taken apart.
            texture = material.parent / (entry.split()[-1] if entry.startswith("-") else entry)
            _must_exist(texture, mesh)
            files.append(texture)
    return tuple(dict.fromkeys(files))


def read_set(files: tuple[Path, ...]) -> tuple[bytes, str]:
    """The bytes of the mesh (the first file) and the SHA-256 of the set.

    The hash runs over name, NUL, length in decimal, NUL, bytes of each file, in order of name.
    """
    mesh = b""
    digest = hashlib.sha256()
    for file in sorted(files, key=lambda path: path.name):
        if file.stat().st_size > MAX_FILE_BYTES:
            raise ScanFileError(f"{file.name} is larger than {MAX_FILE_BYTES >> 30} GiB")
        data = file.read_bytes()
        digest.update(f"{file.name}\0{len(data)}\0".encode())
        digest.update(data)
        if file == files[0]:
            mesh = data
        else:
            _check_picture(file, data)
    return mesh, digest.hexdigest()


def declared_unit(data: bytes) -> str | None:
    """The unit that a PLY's header says of itself, in a line such as `comment unit mm` or `comment Units: meters`."""
    head, end, _ = data[:MAX_HEADER_BYTES].partition(b"end_header")
    if not (data.startswith(b"ply") and end):
        return None
    found = re.search(
        rb"^(?:comment|obj_info)\s+units?\b\s*[:=]?\s*([a-z]+)\s*$", head, re.MULTILINE | re.IGNORECASE
    )
    return _UNIT_WORDS.get(found[1].decode().lower().removesuffix("s")) if found else None


def parse(data: bytes, name: str) -> Geometry:
    """Check and read a mesh or cloud; `name` gives the format by its suffix."""
    suffix = Path(name).suffix.lower()
    if suffix == ".xyz":
        return _parse_xyz(data, name)
    checks = {".ply": _check_ply, ".stl": _check_stl, ".obj": _check_obj}
    if suffix not in checks:
        raise ScanFileError(f"{name}: not a format that is read (OBJ, PLY, STL, XYZ)")
    vertex_count, face_count = checks[suffix](data, name)
    geometry = _load(data, suffix[1:], name)
    _check_loaded(geometry, vertex_count, face_count, name)
    return geometry


def weld(vertices_mm: NDArray[np.float64], triangles: NDArray[np.int64]) -> Geometry:
    """Merge vertices within `WELD_MM` (seams, STL's corners) and drop triangles that collapse."""
    if len(triangles) == 0:
        return Geometry(vertices_mm, triangles)
    grid = np.round(vertices_mm / WELD_MM).astype(np.int64)
    _, first, inverse = np.unique(grid, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    welded = rank[inverse.reshape(-1)][triangles]
    distinct = (
        (welded[:, 0] != welded[:, 1]) & (welded[:, 1] != welded[:, 2]) & (welded[:, 2] != welded[:, 0])
    )
    return Geometry(vertices_mm[first[order]], welded[distinct])


def _names(file: Path, pattern: bytes) -> list[str]:
    if file.stat().st_size > MAX_FILE_BYTES:
        raise ScanFileError(f"{file.name} is larger than {MAX_FILE_BYTES >> 30} GiB")
    head = file.read_bytes() if file.suffix.lower() == ".mtl" else _head(file)
    names = [match.decode("utf-8", "replace") for match in re.findall(pattern, head, re.MULTILINE)]
    for name in names:
        if Path(name).is_absolute() or ".." in Path(name).parts:
            raise ScanFileError(f"{file.name} names a file outside its folder: {name}")
    return names


def _head(file: Path) -> bytes:
    with file.open("rb") as stream:
        return stream.read(MAX_HEADER_BYTES)


def _must_exist(file: Path, mesh: Path) -> None:
    if not file.is_file():
        raise IncompleteError(f"{mesh.name} needs {file.name}, which is not there")


def _check_picture(file: Path, data: bytes) -> None:
    suffix = file.suffix.lower()
    whole = {
        ".png": data.startswith(b"\x89PNG") and data.endswith(b"IEND\xaeB`\x82"),
        ".jpg": data.startswith(b"\xff\xd8") and data.rstrip(b"\0").endswith(b"\xff\xd9"),
        ".jpeg": data.startswith(b"\xff\xd8") and data.rstrip(b"\0").endswith(b"\xff\xd9"),
    }.get(suffix, True)
    if not whole:
        raise IncompleteError(f"{file.name} is cut short ({len(data)} bytes)")


def _check_ply(data: bytes, name: str) -> tuple[int, int]:
    end = re.search(rb"^end_header\r?\n", data[:MAX_HEADER_BYTES], re.MULTILINE)
    if not data.startswith(b"ply") or end is None:
        raise IncompleteError(f"{name} has no complete PLY header")
    header = data[: end.start()].decode("ascii", "replace").splitlines()
    counts: dict[str, int] = {}
    least: dict[str, int] = {}
    element, is_text = "", False
    for line in header:
        words = line.split()
        if words[:1] == ["format"]:
            is_text = words[1:2] == ["ascii"]
        elif words[:1] == ["element"] and len(words) == 3 and words[2].isdigit():
            element = words[1]
            counts[element] = _counted(int(words[2]), name)
            least[element] = 0
        elif words[:1] == ["property"] and element:
            is_list = words[1:2] == ["list"]
            kinds = words[2:4] if is_list else words[1:2]
            whole = len(words) == (5 if is_list else 3)
            if not whole or any(kind not in _PLY_BYTES for kind in kinds):
                raise ScanFileError(f"{name} has a property that is not understood: {line.strip()!r}")
            sizes = [_PLY_BYTES[kind] for kind in kinds]
            corners = 3 if element == "face" and "vert" in words[-1] else 0
            least[element] += sizes[0] + corners * sizes[1] if is_list else sizes[0]
    body = len(data) - end.end()
    if is_text:
        rows = data.count(b"\n", end.end()) + (not data.endswith(b"\n"))
        needed = sum(counts.values())
        if rows < needed or not data.endswith(b"\n"):
            raise IncompleteError(f"{name} promises {needed} lines and has {rows}, or its last one is cut")
    else:
        needed = sum(counts[part] * least[part] for part in counts)
        if body < needed:
            raise IncompleteError(f"{name} promises at least {needed} bytes after its header and has {body}")
    return counts.get("vertex", 0), counts.get("face", 0)


def _check_stl(data: bytes, name: str) -> tuple[int, int]:
    if len(data) >= 84:
        count = int.from_bytes(data[80:84], "little")
        if len(data) == 84 + 50 * count:
            return 3 * _counted(count, name), count
    text = data[:5].lower() == b"solid" and b"facet" in data[:MAX_HEADER_BYTES]
    if not text:
        raise IncompleteError(f"{name} is not as long as its STL header promises ({len(data)} bytes)")
    if not re.search(rb"endsolid[^\n]*\s*$", data[-1024:]):
        raise IncompleteError(f"{name} has no endsolid line")
    count = len(re.findall(rb"^\s*endfacet", data, re.MULTILINE))
    return 3 * count, count


def _check_obj(data: bytes, name: str) -> tuple[int, int]:
    if not data.endswith(b"\n"):
        raise IncompleteError(
            f"{name} ends in the middle of a line: it was cut off, or has no line break at its end"
        )
    objects = re.findall(rb"^o[ \t]+(.+?)[ \t]*\r?$", data, re.MULTILINE)
    if len(set(objects)) > 1:
        listed = ", ".join(sorted({text.decode("utf-8", "replace") for text in objects})[:5])
        raise ScanFileError(f"{name} holds several objects ({listed}): export one scan to a file")
    if re.search(rb"^v[ \t][^\n]*(?:nan|inf)", data, re.MULTILINE | re.IGNORECASE):
        raise ScanFileError(f"{name} has a vertex that is no number")
    if re.search(rb"^f[^\n]*[ \t](?:0[/ \t\r\n]|-)", data, re.MULTILINE):
        raise ScanFileError(f"{name} has a face with an index below 1")
    vertices = len(re.findall(rb"^v[ \t]", data, re.MULTILINE))
    faces = len(re.findall(rb"^f[ \t]", data, re.MULTILINE))
    promised = re.search(rb"^#[^\n]*?(?:faces|triangles)\s*:?\s*(\d+)", data[:4096], re.MULTILINE | re.I)
    if promised is not None and int(promised[1]) > faces:
        raise IncompleteError(f"{name} promises {int(promised[1])} faces and has {faces}")
    if faces == 0:
        raise IncompleteError(f"{name} has {vertices} vertices and no faces")
    return vertices, faces


def _counted(count: int, name: str) -> int:
    if count > MAX_ELEMENTS:
        raise ScanFileError(f"{name} promises {count} elements, more than any scan has")
    return count


def _load(data: bytes, kind: str, name: str) -> Geometry:
    import trimesh

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            loaded = trimesh.load(io.BytesIO(data), file_type=kind, process=False, skip_materials=True)
        # an empty file is read as a scene, which has none
        vertices = np.array(getattr(loaded, "vertices", ()), np.float64).reshape(-1, 3)
        triangles = np.array(getattr(loaded, "faces", ()), np.int64).reshape(-1, 3)
    except MemoryError:
        raise ScanFileError(f"{name} does not fit into memory") from None
    except Exception as error:  # whatever the library makes of damaged bytes
        why = " ".join(str(error).split())[:120]
        raise ScanFileError(f"{name} cannot be read: {type(error).__name__}: {why}") from None
    return Geometry(vertices, triangles)


def _check_loaded(geometry: Geometry, vertex_count: int, face_count: int, name: str) -> None:
    vertices, triangles = geometry.vertices, geometry.triangles
    if len(vertices) == 0:
        raise ScanFileError(f"{name} holds no vertices")
    if not np.isfinite(vertices).all():
        raise ScanFileError(
            f"{name} has {np.count_nonzero(~np.isfinite(vertices))} coordinates that are no numbers"
        )
    if len(triangles) < face_count:
        raise ScanFileError(f"{name} promises {face_count} faces, {len(triangles)} could be read")
    if len(triangles) and (triangles.min() < 0 or triangles.max() >= len(vertices)):
        raise ScanFileError(f"{name} has a face with a vertex that does not exist (of {vertex_count})")


def _parse_xyz(data: bytes, name: str) -> Geometry:
    if not data.endswith(b"\n"):
        raise IncompleteError(
            f"{name} ends in the middle of a line: it was cut off, or has no line break at its end"
        )
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            vertices = np.loadtxt(io.BytesIO(data), usecols=(0, 1, 2), ndmin=2)
    except (ValueError, IndexError) as error:
        raise ScanFileError(f"{name} is not a list of x y z: {' '.join(str(error).split())[:120]}") from None
    geometry = Geometry(vertices.reshape(-1, 3), np.zeros((0, 3), np.int64))
    _check_loaded(geometry, len(geometry.vertices), 0, name)
    return geometry
