"""An experiment on a rig: what the rig allows, whether it is the one of the runs, and how long it will take."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from labrig._errors import LabrigError
from labrig.experiment._experiment import Experiment
from labrig.experiment._plan import Limits

if TYPE_CHECKING:
    from xarray import Dataset

    from labrig.rig import RigConfig


def limits_of(config: "RigConfig") -> Limits:
    """What a rig allows, (C,): kPa, and kPa/s."""
    chambers = config.chambers
    return Limits(
        np.array([c.min_kpa for c in chambers]),
        np.array([c.max_kpa for c in chambers]),
        np.array([c.slew_kpa_s for c in chambers]),
    )


def check_rig(config: "RigConfig", run: "Dataset", rig: str = "") -> None:
    """Raise `LabrigError` if a rig, called `rig` in what is said, is not the one of a run."""
    chambers = [str(c) for c in run["chamber"].values]
    own = [c.name for c in config.chambers]
    name = str(run.attrs.get("run", "the run"))
    if own != chambers:
        raise LabrigError(
            f"{rig or f'rig {config.name}'}: its chambers ({', '.join(own)}) are not those of {name} "
            f"({', '.join(chambers)})"
        )
    unit = str(run["commanded"].attrs.get("units", ""))
    if unit != "kPa":
        raise LabrigError(f"{name}: its actuation is in {unit or 'no unit'}; a rig's is in kPa")


def on_rig(experiment: Experiment, config: "RigConfig") -> Experiment:
    """The experiment as a rig would do it, by a dry run: its `minutes`, and the name of the `rig` beside them.

    Raises `LabrigError` if it would break a limit.
    """
    from labrig.campaign import dry_run
    from labrig_procedures import Programme

    plan = dry_run(Programme.model_validate({"points": experiment.programme()}), config)
    if plan.broken:
        raise LabrigError(f"the proposed programme would break a limit: {plan.broken[0]}")
    known = {"minutes": plan.duration_s / 60, "rig": config.name}
    return replace(experiment, summary={**experiment.summary, **known})
