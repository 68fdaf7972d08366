"""Exports as Artec Studio and its operator make them: real files, written slowly and in place."""

import contextlib
import struct
import time
import zlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from labrig_drivers._artec_files import MM_PER_UNIT
from labrig_drivers.simulated._threaded import Threaded
from labrig_drivers.simulated._wire_plant import SharedPlant

CHUNK_BYTES = 1 << 16


class ArtecTwin(Threaded):
    """Writes the plant's surface into `folder` as ``Eva scan 1``, ``Eva scan 2``, ...

    `formats` from obj (with MTL and PNG), ply, stl, xyz; `unit` as set in Artec Studio; `seams` splits an
    OBJ's surface into two patches of texture; `noise_mm` is the scanner's; `truncate` keeps only that part
    of the mesh file. With `every_s` the operator exports again and again from a thread, and with `keep`
    clears all but so many scans away.
    """

    def __init__(
        self,
        plant: SharedPlant,
        folder: Path,
        *,
        formats: Sequence[str] = ("obj",),
        unit: str = "mm",
        bytes_per_s: float = 20e6,
        seams: bool = False,
        noise_mm: float = 0.05,
        truncate: float | None = None,
        registration_error_mm: float | None = None,
        every_s: float | None = None,
        keep: int | None = None,
        seed: int = 0,
    ) -> None:
        self.folder = folder
        self.number = 0
        self.truncate = truncate
        self._plant = plant
        self._formats = tuple(formats)
        self._unit = unit
        self._bytes_per_s = bytes_per_s
        self._seams = seams
        self._noise_mm = noise_mm
        self._registration_error_mm = registration_error_mm
        self._every_s = every_s
        self._keep = keep
        self._chance = np.random.default_rng(seed)
        super().__init__()

    def start(self) -> "ArtecTwin":
        """Create the folder and, with `every_s`, begin to export."""
        self.folder.mkdir(parents=True, exist_ok=True)
        if self._every_s is not None:
            self._begin("artec-twin", self._run)
        return self

    def export(self) -> str:
        """Scan the surface as it is now and write it; returns the scan's name when all is written."""
        self.number += 1
        name = f"Eva scan {self.number}"
        vertices_mm, triangles = self._plant.surface()
        vertices_mm = vertices_mm + self._noise_mm * self._chance.standard_normal(vertices_mm.shape)
        vertices = vertices_mm / MM_PER_UNIT[self._unit]
        if self._registration_error_mm is not None:
            text = f"registration_error_mm: {self._registration_error_mm:g}\n"
            (self.folder / f"{name}.yaml").write_text(text, encoding="utf-8")
        for kind in self._formats:
            if kind == "obj":
                data = obj_bytes(vertices, triangles, f"{name}.mtl", self._seams)
            else:
                data = {"ply": ply_bytes, "stl": stl_bytes, "xyz": xyz_bytes}[kind](vertices, triangles)
            self._write(self.folder / f"{name}.{kind}", data, cut=True)
            if kind == "obj":
                material = f"newmtl scan\nKd 1 1 1\nmap_Kd {name}.png\n"
                self._write(self.folder / f"{name}.mtl", material.encode())
                self._write(self.folder / f"{name}.png", png_bytes(8, 8))
        if self._keep is not None:
            self._clear_away(self.number - self._keep)
        return name

    def _run(self) -> None:
        assert self._every_s is not None
        while not self._stopping.wait(self._every_s):
            self.export()

    def _clear_away(self, number: int) -> None:
        for suffix in ("obj", "mtl", "png", "ply", "stl", "xyz", "yaml"):
            with contextlib.suppress(OSError):  # somebody may be reading it
                (self.folder / f"Eva scan {number}.{suffix}").unlink(missing_ok=True)

    def _write(self, path: Path, data: bytes, cut: bool = False) -> None:
        if cut and self.truncate is not None:
            data = data[: int(len(data) * self.truncate)]
        chunk = max(1, min(CHUNK_BYTES, len(data) // 8 + 1))
        with path.open("wb") as file:
            for start in range(0, len(data), chunk):
                if self._stopping.is_set() and self._thread is not None:
                    return
                piece = data[start : start + chunk]
                file.write(piece)
                file.flush()
                time.sleep(len(piece) / self._bytes_per_s)


def obj_bytes(
    vertices: NDArray[np.float64], triangles: NDArray[np.int64], material: str, seams: bool
) -> bytes:
    """An OBJ with texture coordinates; with `seams` each half of the triangles has its own patch."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    uv = (vertices[:, :2] - low[:2]) / np.maximum(high[:2] - low[:2], 1e-12)
    lines = [f"mtllib {material}", "usemtl scan"]
    lines += [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in vertices.tolist()]
    lines += [f"vt {u:.6f} {v:.6f}" for u, v in uv.tolist()]
    if seams:
        lines += [f"vt {u / 2:.6f} {v / 2:.6f}" for u, v in uv.tolist()]
    for number, corners in enumerate((triangles + 1).tolist()):
        shift = len(vertices) if seams and number >= len(triangles) // 2 else 0
        lines.append("f " + " ".join(f"{corner}/{corner + shift}" for corner in corners))
    return ("\n".join(lines) + "\n").encode()


def ply_bytes(vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> bytes:
    """A binary little-endian PLY."""
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    faces = np.zeros(len(triangles), np.dtype([("count", "u1"), ("corners", "<i4", 3)]))
    faces["count"] = 3
    faces["corners"] = triangles
    return header.encode() + vertices.astype("<f4").tobytes() + faces.tobytes()


def stl_bytes(vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> bytes:
    """A binary STL."""
    corners = vertices[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    facets = np.zeros(
        len(triangles), np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    )
    facets["normal"] = normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    facets["corners"] = corners
    return b"exported scan".ljust(80, b"\0") + struct.pack("<I", len(triangles)) + facets.tobytes()


def xyz_bytes(vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> bytes:
    """A cloud with a colour for each point, as XYZRGB."""
    del triangles
    return "".join(f"{x:.6f} {y:.6f} {z:.6f} 200 180 160\n" for x, y, z in vertices.tolist()).encode()


def png_bytes(width: int, height: int) -> bytes:
    """A small picture of one colour."""

    def chunk(kind: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    rows = (b"\0" + b"\xc8\xb4\xa0" * width) * height
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    body = chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + body
