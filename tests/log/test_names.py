"""What the names of foreign columns say: units as people write them, and never the tail of a name."""

import pytest

from labrig.tables._names import take_apart
from labrig.tables._spelling import unit_of


@pytest.mark.parametrize(
    ("name", "unit", "called"),
    [
        ("P1 set (bar(g))", "bar", "P1 set"),
        ("p1_set_kPa_g", "kPa", "p1_set"),
        ("p1 [bar a]", "bar", "p1"),
        ("p1 (bar(a))", "bar", "p1"),
        ("p1 bar abs", "bar", "p1"),
        ("P1 (kPa, gauge)", "kPa", "P1"),
        ("P1 (gauge kPa)", "kPa", "P1"),
        ("P1 (kPa) set", "kPa", "P1 set"),
        ("# p_set_kPa", "kPa", "p_set"),
        ("# of cycles", None, "# of cycles"),
        ("p1_kPag", "kPa", "p1"),
        ("torque (N.m)", "N*m", "torque"),
        ("torque_N_m", "N*m", "torque"),
        ("flow_l_min", "l/min", "flow"),
        ("flow NL/min", "slpm", "flow"),
        ("strain_um/m", "um/m", "strain"),
        ("kappa1_1/m", "1/m", "kappa1"),
        ("p_1/kPa", "kPa", "p_1"),
        ("syringe_ml", "ml", "syringe"),
        ("P1 / atm", "atm", "P1"),
        ("F/N", "N", "F"),
        ("t/s", "s", "t"),
        ("kPa_1", "kPa", "kPa_1"),
        ("load_lbf", "lbf", "load"),
        ("Winkel [Grad]", "deg", "Winkel"),
        ("p_kPa.3", "kPa", "p.3"),
        ("heights_mm.0.4", "mm", "heights.0.4"),
        ("room_temp_C", "degC", "room_temp"),
        ("pump_current_A", "A", "pump_current"),
        ("PWM1_pct", "percent", "PWM1"),
        ("力(N)", "N", "力"),
        ("stretch_1_fF", "fF", "stretch_1"),
        ("cap1_pF", "pF", "cap1"),
        ("HV_cmd_kV", "kV", "HV_cmd"),
        ("I_mon_uA", "uA", "I_mon"),
        ("coil_mW", "mW", "coil"),
        ("strain [1]", "1", "strain"),
        ("Druck in mbar", "mbar", "Druck"),
        ("pression en kPa", "kPa", "pression"),
        ("p_in_bar", "bar", "p_in"),
        ("p_set_cmH2O", "cmH2O", "p_set"),
        ("Paw (cmh2o)", "cmH2O", "Paw"),
        ("p line inH2O", "inH2O", "p line"),
    ],
)
def test_a_unit_is_found_in_a_name(name: str, unit: str, called: str) -> None:
    """A unit in brackets, behind a slash or at the end is taken off; gauge and absolute are dropped."""
    taken = take_apart(name)
    assert (taken.unit, taken.called, taken.written) == (unit, called, "")


@pytest.mark.parametrize(
    "name",
    [
        "p1_m",
        "p_s",
        "force_min",
        "flow XL/min",
        "valve_A",
        "pad",
        "P (1)",
        "tip (hand)",
        "current (a)",
        "u_ff",
        "/cmd.data[1]",
    ],
)
def test_the_tail_of_a_name_is_no_unit(name: str) -> None:
    """What a library of units knows by accident, or what can't be the unit of such a thing, is none."""
    assert take_apart(name).unit is None


@pytest.mark.parametrize("said", ["x10 kPa", "10^5 Pa", "x1e5 Pa", "0-5 V = 0-500 kPa", "ADC", "% FS"])
def test_what_is_no_unit_is_kept_to_be_said(said: str) -> None:
    """Where brackets hold a factor, a scale or a word, no unit is taken, and what is written there is known."""
    taken = take_apart(f"P1 set ({said})")
    assert (taken.unit, taken.written, taken.words) == (None, said, taken.words)
    assert taken.words[:3] == ("p", "1", "set")


@pytest.mark.parametrize(
    ("written", "unit"),
    [
        ("mNm", "mN*m"),
        ("Nmm", "N*mm"),
        ("N·m", "N*m"),
        ("m/s2", "m/s**2"),
        ("N/mm2", "N/mm**2"),
        ("kgf/cm2", "kgf/cm**2"),
        ("kg/cm2", "kgf/cm**2"),
        ("cmH2O", "cmH2O"),
        ("1/s", "1/s"),
        ("psid", "psi"),
        ("barü", "bar"),
        ("\u03a9", "ohm"),
        ("k\u2126", "kohm"),
        ("\u2103", "degC"),
        ("°F", "degF"),
        ("µL/min", "uL/min"),
        ("SLPM", "slpm"),
        ("Torr", "torr"),
        ("g", "g"),
        ("a", None),
        ("hand", None),
        ("sccm", None),
    ],
)
def test_units_as_people_write_them(written: str, unit: str | None) -> None:
    """Products, powers and signs become what pint reads; what no instrument gives is no unit."""
    assert unit_of(written) == unit


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("压力1", ("压力", "1")),
        ("mesuré_1", ("mesuré", "1")),
        ("Pset1", ("p", "set", "1")),
        ("Vfb_2", ("v", "fb", "2")),
        ("measP1", ("meas", "p", "1")),
    ],
)
def test_words_of_any_script(name: str, words: tuple[str, ...]) -> None:
    """Letters of every script make words, and a chamber's letter before or behind a role is its own."""
    assert take_apart(name).words == words


def test_a_place_in_an_array_is_part_of_a_name() -> None:
    """points[1].x, as programs flatten their messages, is the x of a point, and its bracket holds no unit."""
    taken = [take_apart(f"/depth/points[{i}].x") for i in (0, 1, 12)]
    assert [n.owner for n in taken] == ["/depth/points[0]", "/depth/points[1]", "/depth/points[12]"]
    assert {(n.unit, n.axis) for n in taken} == {(None, "x")}
    assert take_apart("/cmd.data[1]").called == "/cmd.data[1]"
