"""Campaigns: procedures yield steps, the runner carries them out, logs them, and leaves the rig vented."""

from labrig.campaign._advice import Adviser
from labrig.campaign._observe import Observer, Progress
from labrig.campaign._plan import Plan, dry_run, plan_sha256, rig_info
from labrig.campaign._procedure import Procedure, RigInfo, Steps
from labrig.campaign._reachable import Reachable
from labrig.campaign._replay import read_completed
from labrig.campaign._runfile import NotResumableError, check_written
from labrig.campaign._runner import Watching, resume, run
from labrig.campaign._session import Control
from labrig.campaign._signals import Interrupted
from labrig.campaign._steps import (
    Actuate,
    Actuated,
    Answered,
    Ask,
    Completed,
    Note,
    Record,
    Recording,
    Result,
    Scan,
    Scanned,
    Settle,
    Settled,
    Step,
    Vent,
    Vented,
)
from labrig.campaign._tally import Tally
from labrig.campaign._walk import ProcedureError

__all__ = [
    "Actuate",
    "Actuated",
    "Adviser",
    "Answered",
    "Ask",
    "Completed",
    "Control",
    "Interrupted",
    "NotResumableError",
    "Note",
    "Observer",
    "Plan",
    "Procedure",
    "ProcedureError",
    "Progress",
    "Reachable",
    "Record",
    "Recording",
    "Result",
    "RigInfo",
    "Scan",
    "Scanned",
    "Settle",
    "Settled",
    "Step",
    "Steps",
    "Tally",
    "Vent",
    "Vented",
    "Watching",
    "check_written",
    "dry_run",
    "plan_sha256",
    "read_completed",
    "resume",
    "rig_info",
    "run",
]
