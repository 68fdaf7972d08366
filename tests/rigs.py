"""The simulated rig of four chambers that several tests hide something in."""

from typing import Any

RIG: dict[str, Any] = {
    "name": "bench",
    "chambers": [{"name": f"c{n}", "max_kpa": 60} for n in range(1, 5)],
    "pressure": {"kind": "simulated"},
    "mocap": {"kind": "simulated", "rate_hz": 20},
    "simulated": {"surface": "membrane", "seed": 0, "hidden": "sealed.json"},
    "follow": {
        "tolerance_kpa": 20,
        "tolerance_share": 0.5,
    },  # what it hides may be a leak or a wrong regulator
}
MODEL = "base: {kind: simulator, rig: rig.yaml}\neffects: []\n"
