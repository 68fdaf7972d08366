"""What takes a guard's place when its driver never comes back and no runner is left: it opens the link and vents."""

import json
import sys
from pathlib import Path

from labrig.rig._config import RigConfig
from labrig.rig._guard_process import Guard
from labrig.rig._guard_words import Setup
from labrig_drivers import RealClock


def main() -> int:
    """Vent until it is confirmed, or the guard's patience is over; the guard's setup is all that it is told."""
    setup: Setup = json.loads(sys.stdin.readline())
    config = RigConfig.model_validate({**setup["rig"], "folder": setup["folder"]})
    guard = Guard(
        config, Path(setup["log"]) if setup["log"] else None, RealClock(setup["offset_s"]), armed=True
    )
    guard.answer({"do": "connect"})  # a link that does not open is tried again with every vent
    guard.vent_alone("the driver did not come back", config.safety.guard_patience_s)
    guard.device.close()
    return int(guard.armed)


if __name__ == "__main__":
    sys.exit(main())
