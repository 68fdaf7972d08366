"""What a run would do, followed in a process of its own: a procedure may be anybody's, and may never end."""

from pathlib import Path
from typing import Any

from labrig.api._procedures import read_procedure
from labrig.rig import load_rig

SHOWN = 4000
LONGEST_S = 180.0
"""A plan that is not there by then is given up."""


def planned(rig_file: str, source: str, arguments: list[str], seed: int) -> dict[str, Any]:
    """Every step with its time, how long it takes, which limits it would break; `plan` names what was planned.

    The name is another one where the procedure, its parameters, the rig or a step is another one.
    """
    from labrig.campaign import dry_run, plan_sha256

    config, procedure = load_rig(Path(rig_file)), read_procedure(source, arguments)
    plan = dry_run(procedure, config, seed)
    first = zip(plan.start_s[:SHOWN], plan.steps[:SHOWN], strict=True)
    return {
        "plan": plan_sha256(procedure, config, seed, plan),
        "steps": [{"at_s": at_s, **step.to_dict()} for at_s, step in first],
        "count": len(plan.steps),
        "captures": plan.captures,
        "duration_s": plan.duration_s,
        "broken": list(plan.broken),
        "stopped": plan.stopped,
        "limits": [[c.name, c.min_kpa, c.max_kpa, c.slew_kpa_s] for c in config.chambers],
    }
