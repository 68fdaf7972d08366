"""The simulated rig of four chambers, few markers and slow cameras that several tests hide something in."""

from typing import Any

RIG: dict[str, Any] = {
    "name": "bench",
    "chambers": [{"name": f"c{n}", "max_kpa": 60} for n in range(1, 5)],
    "markers": ["m01", "m03", "m04", "m06", "m09", "m11", "m12", "m14", "m16"],
    "pressure": {"kind": "simulated", "rate_hz": 5},
    "mocap": {"kind": "simulated", "rate_hz": 5},
    "simulated": {"surface": "membrane", "seed": 0, "hidden": "sealed.json"},
    "follow": {
        "tolerance_kpa": 20,
        "tolerance_share": 0.5,
    },  # what it hides may be a leak or a wrong regulator
}
MODEL = "base: {kind: simulator, rig: rig.yaml}\neffects: []\n"
