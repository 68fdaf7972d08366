"""Files of learned models: plain arrays and JSON in one zip archive, nothing in them that could be run."""

import json
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from labrig._durable import aside, put_at
from labrig._errors import LabrigError
from labrig._paths import check_parent

FORMAT = "labrig learned model"
VERSION = 2
"""2: corrected models tell how well their field is known; 1 is read as ever."""
_FACTS = "facts.json"
_LARGEST = 2**31
"""Bytes that a file may unpack to: a small file must not fill the memory."""

Arrays = dict[str, NDArray[Any]]


def write_file(path: str | Path, facts: dict[str, Any], arrays: Arrays) -> None:
    """Write facts and arrays, in one piece or not at all."""
    path = Path(path)
    check_parent(path)
    head = {"format": FORMAT, "version": VERSION, **facts}
    with aside(path) as partial:
        with zipfile.ZipFile(partial, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
            archive.writestr(_entry(_FACTS), json.dumps(head, indent=1, sort_keys=True))
            for name in sorted(arrays):
                with archive.open(_entry(f"{name}.npy"), "w", force_zip64=True) as file:
                    np.lib.format.write_array(file, np.ascontiguousarray(arrays[name]), allow_pickle=False)
        put_at(partial, path)


def _entry(name: str) -> zipfile.ZipInfo:
    """An entry without a date: equal models are equal files."""
    entry = zipfile.ZipInfo(name)
    entry.compress_type = zipfile.ZIP_DEFLATED
    return entry


def read_file(path: str | Path) -> tuple[dict[str, Any], Arrays]:
    """Read facts and arrays back; raises `LabrigError` for anything that is not a whole file of labrig's."""
    path = Path(path)
    try:
        with zipfile.ZipFile(path) as archive:
            entries = archive.infolist()
            if _FACTS not in {entry.filename for entry in entries}:
                raise LabrigError(f"{path}: is not a learned model of labrig's (it has no {_FACTS})")
            if sum(entry.file_size for entry in entries) > _LARGEST:
                raise LabrigError(
                    f"{path}: unpacks to more than {_LARGEST >> 30} GiB; that is no learned model"
                )
            facts = json.loads(archive.read(_FACTS))
            _check_version(path, facts)
            arrays: Arrays = {}
            for entry in entries:
                if entry.filename.endswith(".npy"):
                    with archive.open(entry) as file:
                        arrays[entry.filename[:-4]] = np.lib.format.read_array(file, allow_pickle=False)
                        file.read()  # to the end, where the checksum is compared
    except FileNotFoundError as error:
        raise LabrigError(f"{path}: does not exist; make it with: labrig train") from error
    except OSError as error:
        raise LabrigError(f"{path}: can't be read ({error.strerror or error})") from error
    # zipfile says RuntimeError, or a child of it, for what is encrypted or packed in a way that it does not know
    except (zipfile.BadZipFile, zlib.error, ValueError, EOFError, KeyError, RuntimeError) as error:
        said = " ".join(str(error).split())
        if isinstance(error, zipfile.BadZipFile):
            raise LabrigError(
                f"{path}: is not a learned model of labrig's ({said}); such a model is a file that "
                "labrig train writes, forward.pt or sim2real.pt"
            ) from error
        raise LabrigError(f"{path}: is damaged ({said}); take a copy of it, or train it again") from error
    return facts, arrays


def _check_version(path: Path, facts: Any) -> None:
    if not isinstance(facts, dict) or facts.get("format") != FORMAT:
        raise LabrigError(f"{path}: is not a learned model of labrig's")
    version = facts.get("version")
    if not isinstance(version, int) or version < 1:
        raise LabrigError(f"{path}: is damaged (its version is {version!r})")
    if version > VERSION:
        raise LabrigError(
            f"{path}: was written by a newer labrig (format {version}, this one reads {VERSION}); update labrig"
        )
