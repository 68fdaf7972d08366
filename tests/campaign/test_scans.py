"""What a scanner exported is kept with its run as it was, and read back from there in its own unit."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

import labrig
from labrig import LabrigError
from labrig.campaign import Actuate, Procedure, RigInfo, Scan, Settle, Steps, run
from labrig.campaign._scans import keep_scan
from labrig.log import last_logged_s
from labrig.surface import grid, read_mesh
from labrig_drivers import DeviceError, RealClock, build_device
from labrig_drivers import Scan as Scanned
from labrig_drivers.simulated._artec_twin import obj_bytes, png_bytes
from tests.rigs import RIG

MM = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "inch": 25.4}


@pytest.mark.parametrize("unit", list(MM))
def test_a_scan_with_colours_is_read_back_from_its_run(tmp_path: Path, unit: str) -> None:
    """An OBJ finds its material and picture beside it, under the names that it knows, and is as large as the body."""
    uv, triangles = grid(21, 21)
    body_mm = np.column_stack([300 * uv[:, 0], 80 * np.sin(np.pi * uv[:, 0]), 200 * uv[:, 1]])
    folder, run = tmp_path / "exports", tmp_path / "run"
    folder.mkdir()
    run.mkdir()
    options = {"folder": "exports", "unit": unit, "settle_s": 0.05}
    device = build_device("artec", options, name="scanner", clock=RealClock(), base=tmp_path)
    device.connect()
    name = "Eva scan 1"
    (folder / f"{name}.png").write_bytes(png_bytes(4, 4))
    (folder / f"{name}.mtl").write_text(f"newmtl scan\nmap_Kd {name}.png\n")
    (folder / f"{name}.obj").write_bytes(obj_bytes(body_mm / MM[unit], triangles, f"{name}.mtl", True))
    scan = device.scan(timeout_s=20)
    device.close()
    kept = keep_scan(scan, run)
    assert kept == tuple(f"scans/000/{name}{suffix}" for suffix in (".obj", ".mtl", ".png"))
    mesh = read_mesh(run / kept[0], scan.unit)
    np.testing.assert_allclose(np.ptp(mesh.vertices_mm, axis=0), np.ptp(body_mm, axis=0), atol=0.1)


def test_scans_are_numbered_without_end(tmp_path: Path) -> None:
    """The one after 999 is 1000, and what older runs called `998_scan.ply` counts, too: nothing is written over."""
    scan = Scanned(0.0, np.eye(3), np.array([[0, 1, 2]]), (), "")
    (tmp_path / "scans").mkdir()
    (tmp_path / "scans" / "998_scan.ply").write_bytes(b"ply")
    kept = [keep_scan(scan, tmp_path) for _ in range(3)]
    assert kept == [("scans/999/scan.ply",), ("scans/1000/scan.ply",), ("scans/1001/scan.ply",)]


class Once(Procedure):
    """One scan."""

    def steps(self, rig: RigInfo) -> Steps:
        """Nothing else."""
        yield Scan()


def _scanning(fake: Any, monkeypatch: pytest.MonkeyPatch, **changes: Any) -> None:
    scanner = fake.rig.scanner._device
    scan = scanner.scan
    monkeypatch.setattr(scanner, "scan", lambda timeout_s: replace(scan(timeout_s), **changes))


def test_a_scanners_clock_does_not_set_the_runs(
    fake: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Files that another computer dates an hour ahead are logged when they came: a resumed run loses no hour."""
    _scanning(fake, monkeypatch, time_s=fake.clock.now_s() + 3600.0)
    run(Once(), fake.rig, tmp_path / "run", fake.clock)
    assert last_logged_s(tmp_path / "run") <= fake.clock.now_s()


def test_a_scan_whose_file_is_gone_is_not_the_log(
    fake: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where somebody moved the export, the message names it, and not the run's log."""
    _scanning(fake, monkeypatch, files=(tmp_path / "exports" / "Eva scan 1.ply",))
    with pytest.raises(
        LabrigError, match=r"Eva scan 1\.ply: No such file or directory; the chambers are vented$"
    ) as caught:
        run(Once(), fake.rig, tmp_path / "run", fake.clock)
    assert "the log" not in str(caught.value)


def test_a_scan_whose_pressures_did_not_follow_is_noticed(fake: Any, tmp_path: Path) -> None:
    """What was read while the scanner worked is held against the set-points, on a simulated clock, too."""

    class Held(Procedure):
        def steps(self, rig: RigInfo) -> Steps:
            yield Actuate((20.0, 10.0))
            yield Settle(3.0)
            yield Scan()

    fake.pressure.faults["leaks"] = {0: np.inf}
    with pytest.raises(DeviceError, match=r"c1 was asked for 20.0 kPa and reads 0.0 kPa"):
        run(Held(), fake.rig, tmp_path / "run", fake.clock)


def test_a_run_without_motion_capture_can_be_opened(tmp_path: Path) -> None:
    """A simulated rig has markers even where no camera looks at them; its run has none, and is read as any other."""
    content = {key: value for key, value in RIG.items() if key not in ("markers", "mocap", "simulated")}
    content |= {"simulated": {"surface": "membrane", "seed": 0}, "scanner": {"kind": "simulated"}}
    (tmp_path / "rig.yaml").write_text(yaml.safe_dump(content))
    labrig.run("survey", tmp_path / "rig.yaml", out=tmp_path / "run", captures=2, scans=1)
    opened = labrig.open_run(tmp_path / "run")
    assert opened.sizes["capture"] == 2
    assert "rest_mm" not in opened
