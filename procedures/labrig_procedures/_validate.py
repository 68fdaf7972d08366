"""The closed loop: shapes that were asked for, realised, scanned and compared."""

from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from labrig.campaign import Actuate, Note, Procedure, Record, RigInfo, Scan, Scanned, Settle, Steps, Vent


class Validate(Procedure):
    """Targets -> inverse kinematics -> actuate, settle, markers, scan; and closer on the rig, where that is allowed.

    Every target is realised with the whole model and, to compare, without its warp or its effects. Each begins vented,
    so that its history is its own. With `refine`, Broyden's method goes on from the scan, at most so many scans more.
    """

    closed_loop: ClassVar[bool] = True

    targets: tuple[str, ...] = Field((), description="files of the shapes")
    model: str = Field("", description="forward.pt, sim2real.pt, or a model file")
    unit: str = Field("", description="unit of the targets, where it is not clear")
    without: tuple[Literal["warp", "effects"], ...] = Field(
        (), description="realised once more without these"
    )
    record_s: float = Field(1.0, gt=0.0, description="length of each recording, s")
    scan_timeout_s: float = Field(120.0, gt=0.0, description="wait for a scan, s")
    refine: int = Field(0, ge=0, le=20, description="scans more for each target, to come closer")
    enough: float = Field(0.02, ge=0.0, lt=1.0, description="gain, as a share, below which refining ends")

    def steps(self, rig: RigInfo) -> Steps:
        """All targets, each from vented."""
        from labrig import LabrigError
        from labrig.ik import make_trials

        if not self.targets or not self.model:
            raise LabrigError(
                "validate needs targets and a model: labrig validate TARGET... --rig RIG --model MODEL"
            )
        if self.refine and not rig.has_scanner:
            raise LabrigError(f"rig {rig.name} has no scanner, and refining needs one")
        trials = make_trials(
            self.targets, self.model, self.unit, self.without, rig.chamber_names, rig.min_kpa, rig.max_kpa
        )
        for trial in trials:
            yield Note(f"{trial.name}, {trial.form}: {trial.approach.name}")
            planned = trial.for_rig(trial.approach)
            setpoint, scanned = yield from self._realise(planned, f"{trial.number}/0", rig)
            if not self.refine or trial.solved.job.without:
                continue
            search, best = trial.refinement(rig.min_kpa, rig.max_kpa), np.inf
            for attempt in range(1, self.refine + 1):
                if scanned is None or scanned.mesh_file is None:  # a dry run has no scans
                    break
                surface, _ = trial.placed(trial.read_scan(scanned.mesh_file, scanned.unit))
                height = trial.heights(surface)
                misfit = float(np.nanmean(np.abs(height)))
                if misfit > (1.0 - self.enough) * best:
                    break
                best, following = misfit, search.propose(np.asarray(setpoint), height)
                approach = _ending_at(planned, following, rig)
                setpoint, scanned = yield from self._realise(approach, f"{trial.number}/{attempt}", rig)

    def _realise(self, approach, label: str, rig: RigInfo):
        """From vented along a path to its end; gives back the last set-point and the scan, if there is a scanner."""
        yield Vent()
        for setpoint, hold_s in zip(approach.setpoints_kpa, approach.holds_s, strict=True):
            yield Actuate(setpoint, label=label)
            yield Settle(hold_s)
        yield Record(self.record_s, label=label)
        scanned: Scanned | None = None
        if rig.has_scanner:
            scanned = yield Scan(self.scan_timeout_s, label=label)
        return approach.setpoints_kpa[-1], scanned


def _ending_at(approach, setpoint, rig: RigInfo):
    """The same path with another end; what came before moves along with it."""
    from dataclasses import replace

    end = np.round(setpoint, 3)
    moved = approach.setpoints_kpa + (end - approach.setpoints_kpa[-1])
    return replace(approach, setpoints_kpa=np.clip(np.round(moved, 3), rig.min_kpa, rig.max_kpa))
