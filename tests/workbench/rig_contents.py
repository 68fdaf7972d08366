"""Contents of rig files that the form of the workbench can hold, drawn at random."""

from typing import Any

from hypothesis import strategies as st

_SIGNS = st.characters(exclude_categories=("C", "Z"), exclude_characters=",")
WORDS = st.text(_SIGNS, min_size=1, max_size=8) | st.sampled_from(
    ["yes", "1e3", "0x1f", "null", "- a", "a: b", "#a", "'", "{", "ü", "1", "~", "1.0", "2026-11-28"]
)
MM = st.floats(-1e4, 1e4)
SECONDS = st.floats(0.01, 30.0) | st.integers(1, 30)
KPA = st.floats(0.01, 100.0) | st.integers(1, 100)
RATES = st.integers(1, 200) | st.floats(0.1, 200)


def some(needed: dict[str, Any], **optional: Any) -> st.SearchStrategy[dict[str, Any]]:
    """Settings of which the optional ones may be left out."""
    return st.fixed_dictionaries(needed, optional=optional)


WATCHED = {"stale_after_s": SECONDS, "over_kpa": KPA, "vent_below_kpa": KPA, "timeout_s": SECONDS}
OPENPNEU = some(
    {"kind": st.just("openpneu"), "port": WORDS},
    dialect=st.sampled_from(["auto", "published", "table"]),
    build=st.sampled_from(["published", "full"]),
    baudrate=st.integers(1, 10**6),
    boot_s=SECONDS,
    **WATCHED,
)
_MODBUS = {"unit_id": st.integers(0, 247), "poll_hz": RATES, **WATCHED}
MODBUS = some(
    {"kind": st.just("modbus"), "map": WORDS, "host": WORDS}, port=st.integers(1, 65535), **_MODBUS
) | some(
    {"kind": st.just("modbus"), "map": WORDS, "serial": WORDS},
    baudrate=st.integers(1, 10**6),
    parity=st.sampled_from("NEO"),
    **_MODBUS,
)
SIMULATED = st.just({"kind": "simulated"})
VICON = some(
    {"kind": st.just("vicon")},
    host=WORDS,
    port=st.integers(1, 65535),
    subject=WORDS | st.none(),
    up=st.sampled_from("yz"),
    unit=st.sampled_from(["mm", "m"]),
    mode=st.sampled_from(["push", "pull", "prefetch"]),
    timeout_s=SECONDS,
    stale_after_s=SECONDS,
    lost_after_s=SECONDS,
)
ARTEC = some(
    {"kind": st.just("artec"), "folder": WORDS, "unit": st.sampled_from(["mm", "cm", "m", "inch"])},
    settle_s=SECONDS,
    stall_s=SECONDS,
)
PLANT = some(
    {"surface": st.sampled_from(["membrane", "mannequin"])},
    seed=st.integers(0, 10**9),
    noise_mm=st.floats(0, 1000),
    occlusion=st.floats(0, 1),
)
SAFETY = some(
    {},
    vents_alone=WORDS,
    heartbeat_s=st.floats(0.2, 30.0) | st.integers(1, 30),
    over_pressure_kpa=KPA,
    stale_pressure_s=SECONDS,
    lost_mocap_s=SECONDS,
    vented_kpa=KPA,
    vent_timeout_s=SECONDS,
    vent_patience_s=SECONDS,
    guard_patience_s=SECONDS,
    think_s=SECONDS,
)
FOLLOW = some(
    {},
    tolerance_kpa=KPA,
    tolerance_share=st.floats(0, 0.99),
    repeats=st.integers(0, 9),
    on_miss=st.sampled_from(["pause", "skip", "abort"]),
)
CHAMBER = some(
    {"max_kpa": st.just(0.0) | st.floats(0.01, 1000) | st.integers(0, 1000)},
    min_kpa=st.just(0.0) | st.floats(-100, -0.01) | st.integers(-100, 0),
    slew_kpa_s=KPA,
)


@st.composite
def contents(draw: st.DrawFn) -> dict[str, Any]:
    """A rig file with any of the devices that the form knows."""
    names = draw(st.lists(WORDS, min_size=1, max_size=6, unique=True))
    content: dict[str, Any] = {"name": draw(WORDS)}
    content["chambers"] = [{"name": name, **draw(CHAMBER)} for name in names]
    content["pressure"] = dict(draw(OPENPNEU | MODBUS | SIMULATED))
    if content["pressure"]["kind"] != "simulated" and draw(st.booleans()):
        content["pressure"]["outputs"] = draw(st.permutations(range(len(names))))
    if (mocap := draw(st.none() | VICON | SIMULATED)) is not None:
        content["mocap"] = mocap
        if markers := draw(st.lists(WORDS, max_size=5, unique=True)):
            content["markers"] = markers
            placed = draw(st.lists(st.sampled_from(markers), unique=True))
            if placed:
                content["rest_mm"] = {name: [draw(MM) for _ in range(3)] for name in placed}
    if (scanner := draw(st.none() | ARTEC | SIMULATED)) is not None:
        content["scanner"] = scanner
    if any(content.get(role, {}).get("kind") == "simulated" for role in ("pressure", "mocap", "scanner")):
        content["simulated"] = draw(PLANT)
    for name, section in (("safety", SAFETY), ("follow", FOLLOW)):
        if given := draw(section):
            content[name] = given
    fullest_kpa = (max(c["max_kpa"], -c.get("min_kpa", 0)) for c in content["chambers"])
    least_kpa = min((kpa for kpa in fullest_kpa if kpa > 0), default=1000)
    if content.get("safety", {}).get("vented_kpa", 3.0) >= least_kpa:  # a full chamber is not vented
        content["safety"] = {**content.get("safety", {}), "vented_kpa": least_kpa / 2}
    return content
