"""What other laboratories save: the same measurements in many formats become the same run, with a guessed mapping."""

import gzip
import json
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

import labrig
from labrig import LabrigError
from labrig.log import guess_mapping, import_guessed, import_table

from .conftest import FRAME, F, N, P, T


def as_hdf5(path: str) -> None:
    """Write HDF5 with a group."""
    import h5py

    with h5py.File(path, "w") as file:
        for name in FRAME:
            file[f"log/{name}"] = FRAME[name].to_numpy()


def as_mat5(path: str) -> None:
    """Write MATLAB's old format, a struct of columns."""
    from scipy.io import savemat

    savemat(path, {"log": {name: FRAME[name].to_numpy()[:, None] for name in FRAME}, "note": "spring"})


def as_mat73(path: str) -> None:
    """Write what MATLAB writes with -v7.3: HDF5 behind 512 bytes of its own, rows lying down."""
    import h5py

    with h5py.File(path, "w", userblock_size=512) as file:
        for name in FRAME:
            file[name] = FRAME[name].to_numpy()[None, :]
            file[name].attrs["MATLAB_class"] = np.bytes_("double")
    with Path(path).open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")


def as_mcap(path: str) -> None:
    """Write a log with JSON messages."""
    from mcap.writer import Writer

    with Path(path).open("wb") as file:
        writer = Writer(file)
        writer.start()
        schema = writer.register_schema("row", "jsonschema", b"{}")
        channel = writer.register_channel("/rig", "json", schema)
        for row in FRAME.to_dict("records"):
            stamp = int(1e18) + round(row["time_s"] * 1e9)
            writer.add_message(channel, stamp, json.dumps(row).encode(), stamp)
        writer.finish()


def as_tdms(path: str) -> None:
    """Write what LabVIEW writes: a group of waveforms, ten samples a second, their units among the properties."""
    from nptdms import ChannelObject, TdmsWriter

    clock = {"wf_increment": 0.1, "wf_start_offset": 0.0}
    with TdmsWriter(path) as file:
        file.write_segment(
            [
                ChannelObject("rig", "p1", P, clock | {"unit_string": "kPa"}),
                ChannelObject("rig", "force", F, clock | {"NI_UnitDescription": "N"}),
            ]
        )


def as_zip(path: str) -> None:
    """Write a zip with one table in it, and what a Mac puts beside it."""
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("data/t.csv", FRAME.to_csv(index=False))
        archive.writestr("__MACOSX/data/._t.csv", "x")


FORMATS: dict[str, Callable[[str], object]] = {
    "t.csv": lambda p: FRAME.to_csv(p, index=False),
    "semicolons.txt": lambda p: FRAME.to_csv(p, index=False, sep=";", decimal=","),
    "tabs.dat": lambda p: FRAME.to_csv(p, index=False, sep="\t"),
    "utf16.csv": lambda p: FRAME.to_csv(p, index=False, encoding="utf-16"),
    "t.xlsx": lambda p: FRAME.to_excel(p, index=False),
    "t.parquet": lambda p: FRAME.to_parquet(p),
    "t.feather": lambda p: FRAME.to_feather(p),
    "t.tdms": as_tdms,
    "t.csv.gz": lambda p: FRAME.to_csv(p, index=False),
    "semicolons.txt.gz": lambda p: FRAME.to_csv(p, index=False, sep=";", decimal=","),
    "t.jsonl.gz": lambda p: FRAME.to_json(p, orient="records", lines=True),
    "t.zip": as_zip,
    "t.npz": lambda p: np.savez(p, allow_pickle=False, **{n: FRAME[n].to_numpy() for n in FRAME}),
    "t.h5": as_hdf5,
    "old.mat": as_mat5,
    "new.mat": as_mat73,
    "t.mcap": as_mcap,
    "mcap.bag": as_mcap,
    "a workbook.csv": lambda p: FRAME.to_excel("x.xlsx", index=False) or Path("x.xlsx").rename(p),
}


@pytest.mark.parametrize("name", list(FORMATS))
def test_every_format_gives_the_same_run(desk: Path, name: str) -> None:
    """Six holds of ten rows, by a guess alone; the last is a workbook with a wrong ending."""
    FORMATS[name](name)
    run, guess, written = import_guessed([Path(name)], Path("run"))
    assert (run.sizes["capture"], run.sizes["time"]) == (6, 10)
    assert run["commanded"].to_numpy()[:, 0] == pytest.approx(P[::10])
    assert run["observed"].to_numpy()[:, :, 0].ravel() == pytest.approx(F)
    assert run["time_s"].to_numpy().ravel() == pytest.approx(T, abs=1e-6)
    assert run["commanded"].attrs["units"] == "kPa"
    assert run["unit"].to_numpy().tolist() == ["N"]
    assert len(guess.preview) == 20
    assert yaml.safe_load(written.read_text(encoding="utf-8")) == guess.mapping
    again = labrig.import_table(written, "again")
    np.testing.assert_array_equal(again["observed"].to_numpy(), run["observed"].to_numpy())


@pytest.mark.parametrize("version", [1, 2])
def test_bags_of_ros(desk: Path, version: int) -> None:
    """Topics of a ROS bag are joined by their own clocks: a pressure at 10 Hz, a force at 25 Hz."""
    pytest.importorskip("rosbags")
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import StoragePlugin
    from rosbags.rosbag2 import Writer as Writer2
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC if version == 1 else Stores.ROS2_HUMBLE)
    kind = "std_msgs/msg/Float64"
    message = store.types[kind]
    messages = [("/pressure_kpa", t, p) for t, p in zip(T, P, strict=True)]
    messages += [("/force_n", t, 2.0 * t) for t in np.arange(0, 5.9, 0.04)]
    messages.sort(key=lambda m: m[1])
    path = Path("run.bag" if version == 1 else "bag")
    writer = Writer1(path) if version == 1 else Writer2(path, version=9, storage_plugin=StoragePlugin.MCAP)
    with writer:
        channels = {
            name: writer.add_connection(name, kind, typestore=store) for name in ("/pressure_kpa", "/force_n")
        }
        encode = store.serialize_ros1 if version == 1 else store.serialize_cdr
        for name, t, value in messages:
            writer.write(channels[name], int(1e18) + round(t * 1e9), bytes(encode(message(value), kind)))
    guess = guess_mapping(path)
    assert [j["how"] for j in guess.mapping["join"]] == ["previous"]
    run, _, _ = import_guessed([path], Path("imported"))
    rows = np.isfinite(run["time_s"].to_numpy())
    force = run["observed"].to_numpy()[rows][:, 0]
    assert force == pytest.approx(2.0 * run["time_s"].to_numpy()[rows], abs=1e-6)
    assert set(np.unique(run["commanded"])) <= set(P)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "cp1252", "mac_roman"])
def test_any_encoding(desk: Path, encoding: str) -> None:
    """Names with accents and degrees are found in each encoding, or read as the mapping says."""
    text = "Zeit [s],Überdruck [kPa],Kraft [N],Raum [°C]\n"
    text += "".join(f"{i},{10 * (i // 5)},{i},21\n" for i in range(40))
    said = encoding == "mac_roman"  # too little text to tell it from the western one
    Path("t.csv").write_bytes(text.encode("utf-8" if said else encoding))
    guess = guess_mapping("t.csv")
    if said:
        Path("t.csv").write_bytes(text.encode(encoding))
        guess.mapping["format"] = {"encoding": encoding}
    assert guess.mapping["actuation"][0]["column"] == "Überdruck [kPa]"
    Path("map.yaml").write_text(yaml.safe_dump(guess.mapping, allow_unicode=True), encoding="utf-8")
    assert labrig.import_table("map.yaml", "run").sizes["capture"] == 8
    guess.mapping["format"] = {"encoding": "no-such"}
    Path("map.yaml").write_text(yaml.safe_dump(guess.mapping, allow_unicode=True), encoding="utf-8")
    with pytest.raises(LabrigError, match=r"t\.csv: there is no encoding 'no-such'"):
        labrig.import_table("map.yaml", "other")


def test_a_log_of_a_bench_is_understood(desk: Path) -> None:
    """Lines above the header, units below it, set-points and sensors, markers, a room: each is taken for what it is."""
    rng = np.random.default_rng(0)
    lines = [
        "Log of bench 3",
        "2024-05-01",
        "t;p_set;p_meas;tip x;tip y;tip z;room;note",
        "ms;bar;bar;mm;mm;mm;degC;",
    ]
    for i in range(50):
        p = 0.2 * (i // 10)
        x = ";".join(f"{v:.3f}".replace(".", ",") for v in rng.normal(size=3) + 20 * p)
        lines.append(f"{20 * i};{p:.2f};{p + 0.01:.3f};{x};21,5;ok".replace(".", ","))
    Path("t.csv").write_text("\n".join(lines) + "\n")
    guess = guess_mapping("t.csv")
    m = guess.mapping
    assert m["format"] == {"separator": ";", "units_row": True, "decimal": ",", "skip_rows": 2}
    assert m["time"] == {"column": "t", "unit": "ms"}
    assert m["actuation"] == [{"column": "p_set", "name": "p_set", "unit": "bar"}]
    assert m["measured"] == [{"column": "p_meas", "name": "p_set", "unit": "bar"}]
    assert [(o["marker"], o["axis"], o["unit"]) for o in m["observables"]] == [
        ("tip", a, "mm") for a in "xyz"
    ]
    assert m["covariates"] == [{"column": "room", "name": "room", "unit": "degC"}]
    assert any("'note' holds no numbers" in r for r in guess.remarks)
    run, _, _ = import_guessed([Path("t.csv")], Path("run"))
    assert run["marker"].to_numpy().tolist() == ["tip"]
    assert run.sizes["capture"] == 5


def test_the_command_prints_its_guess(desk: Path, labrig) -> None:
    """`labrig import FILE` shows the mapping, writes it beside the run, and does not replace one that is there."""
    FRAME.to_csv("t.csv", index=False)
    code, out, err = labrig("import", "t.csv")
    assert (code, err) == (0, "")
    assert out.startswith("guessed, and written to t.map.yaml:\n  table: t.csv\n")
    assert out.endswith("t: 6 captures, 1 actuated, 1 observable, 1 session\n")
    assert sorted(p.name for p in Path().iterdir()) == ["t", "t.csv", "t.map.yaml"]
    assert labrig("import", "--mapping", "t.map.yaml", "-o", "again")[0] == 0
    code, out, err = labrig("import", "t.csv", "-o", "t")
    said = "t exists already; choose another name, or replace it (--replace, in Python replace=True)"
    assert (code, out, err) == (2, "", f"labrig: {said}\n")


def test_dates_are_a_clock(desk: Path) -> None:
    """A column of dates and times of day is taken for the time, in s since its first row."""
    frame = FRAME.drop(columns="time_s")
    frame.insert(0, "when", pd.Timestamp("2024-03-01 12:00") + pd.to_timedelta(T, unit="s"))
    frame.to_csv("t.csv", index=False)
    run, guess, _ = import_guessed([Path("t.csv")], Path("run"))
    assert guess.mapping["time"] == {"column": "when", "unit": "date"}
    assert run["time_s"].to_numpy().ravel() == pytest.approx(T, abs=1e-6)


@pytest.mark.parametrize("first", ["p1_kPa", "set", "voltage"])
def test_an_input_that_only_rises_is_no_time(desk: Path, first: str) -> None:
    """A ramp of the input in the first column stays the input, also where nothing else is a time."""
    rows = "".join(f"{5 * i},{0.1 * i * i}\n" for i in range(20))
    Path("t.csv").write_text(f"{first},force_N\n{rows}")
    guess = guess_mapping("t.csv")
    assert [a["column"] for a in guess.mapping["actuation"]] == [first]
    assert "time" not in guess.mapping


def test_what_has_another_unit_is_no_time(desk: Path) -> None:
    """A temperature that is called T, and only rises, is not taken for the time before the clock beside it is."""
    rows = "".join(f"{20 + 0.01 * i},{2 * i},{i % 5},{i}\n" for i in range(20))
    Path("t.csv").write_text(f"T_degC,clock_s,p_kPa,force_N\n{rows}")
    assert guess_mapping("t.csv").mapping["time"] == {"column": "clock_s", "unit": "s"}


def test_a_counter_of_set_points_is_the_capture(desk: Path) -> None:
    """A column `Nr` that counts set-points, each over several rows, cuts the captures and is nothing measured."""
    rows = "".join(f"{i},{1 + i // 4},{10 * (i // 4)},{i % 7}\n" for i in range(40))
    Path("t.csv").write_text(f"t_s,Nr,p_kPa,force_N\n{rows}")
    guess = guess_mapping("t.csv").mapping
    assert guess["capture"] == {"column": "Nr"}
    assert [o["column"] for o in guess["observables"]] == ["force_N"]


def test_a_counter_of_rows_is_left_out(desk: Path) -> None:
    """A column `Nr` that counts every row says nothing, and is said to be left out."""
    rows = "".join(f"{i},{1 + i},{10 * (i // 4)},{i % 7}\n" for i in range(40))
    Path("t.csv").write_text(f"t_s,Nr,p_kPa,force_N\n{rows}")
    guess = guess_mapping("t.csv")
    assert guess.mapping["capture"] == {"per": "segment"}
    assert "column 'Nr' counts rows and is left out" in guess.remarks


@pytest.mark.parametrize("word", ["-", "--", "OVL", "#NV", "k.A.", "n/a", "Err", "\u2014"])
def test_what_instruments_write_where_they_have_no_number(desk: Path, word: str) -> None:
    """A dash, an overload, a spreadsheet's error: nothing was measured there, and all else is read."""
    force = [word if i in (13, 17, 44) else f"{f:.4f}" for i, f in enumerate(F)]
    FRAME.assign(force_n=force).to_csv("t.csv", index=False)
    import_guessed([Path("t.csv")], Path("run"))
    seen = labrig.open_run("run")["observed"].values.ravel()
    assert np.isfinite(seen).sum() == N - 3
    assert seen[np.isfinite(seen)] == pytest.approx(np.delete(F, [13, 17, 44]), abs=1e-4)


def test_frames_that_are_counted_are_a_clock(desk: Path) -> None:
    """Of a camera that counts frames, the rate says when each was; a unit beside it is refused."""
    pd.DataFrame({"frame": np.arange(N) * 12, "p": P, "f": F}).to_csv("t.csv", index=False)
    content = {
        "table": "t.csv",
        "time": {"column": "frame", "rate_hz": 120},
        "actuation": [{"column": "p", "name": "c1", "unit": "kPa"}],
        "observables": [{"column": "f", "name": "force", "unit": "N"}],
    }
    Path("m.yaml").write_text(yaml.safe_dump(content))
    import_table(Path("m.yaml"), Path("run"))
    run = labrig.open_run("run")
    time = run["time_s"].values
    assert np.sort(time[np.isfinite(time)]) == pytest.approx(T)
    content["time"]["unit"] = "s"
    Path("m.yaml").write_text(yaml.safe_dump(content))
    with pytest.raises(LabrigError, match="a clock has a unit, or is frames at a rate_hz, not both"):
        import_table(Path("m.yaml"), Path("run2"))


_CUT = "is packed, and can't be unpacked: it was cut off, or is damaged"


@pytest.mark.parametrize(
    ("cut", "what"),
    [
        (lambda p: p.write_bytes(p.read_bytes()[:80]), _CUT),
        (lambda p: p.write_bytes(p.read_bytes()[:-20]), _CUT),
        (lambda p: p.write_bytes(gzip.compress(b"PAR1" * 20)), "is packed; only text is read so, unpack it"),
    ],
)
def test_what_is_packed_and_can_not_be_read(desk: Path, cut: Callable[[Path], object], what: str) -> None:
    """A gzip that was cut off, or that holds something else than text, is refused in one line, and no run is made."""
    FRAME.to_csv("t.csv.gz", index=False)
    cut(Path("t.csv.gz"))
    with pytest.raises(LabrigError, match=rf"t\.csv\.gz: {what}"):
        import_guessed([Path("t.csv.gz")], Path("run"))
    assert not Path("run").exists()


def test_a_zip_of_several_tables(desk: Path) -> None:
    """Which of them is meant is not guessed: it says to unpack them."""
    with zipfile.ZipFile("t.zip", "w") as archive:
        archive.writestr("a.csv", FRAME.to_csv(index=False))
        archive.writestr("b.csv", FRAME.to_csv(index=False))
    with pytest.raises(LabrigError, match=r"t\.zip: has 2 files in it; unpack it, and name the tables"):
        import_guessed([Path("t.zip")], Path("run"))


def test_channels_of_labview_at_two_rates(
    desk: Path, capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    """Groups with clocks of their own are joined; a file that was cut off is read as far as it goes, without a word
    from the library that reads it.
    """
    from nptdms import ChannelObject, TdmsWriter

    with TdmsWriter("t.tdms") as file:
        for _ in range(2):
            p0 = ChannelObject("AO", "p0", P, {"wf_increment": 0.1, "unit_string": "kPa"})
            f = ChannelObject("AI", "f", np.repeat(2 * P, 10), {"wf_increment": 0.01, "unit_string": "N"})
            file.write_segment([p0, f])
    whole = Path("t.tdms").read_bytes()
    Path("cut.tdms").write_bytes(whole[:-400])
    for name, holds in (("t.tdms", 12), ("cut.tdms", 11)):
        run, guess, _ = import_guessed([Path(name)], Path(name).with_suffix(".run"))
        assert guess.mapping["join"][0]["how"] == "previous"
        assert run.sizes["capture"] >= holds
        seen, set_to = run["observed"].to_numpy()[:, 0, 0], run["commanded"].to_numpy()[:, 0]
        assert seen == pytest.approx(2 * set_to)
    assert capfd.readouterr() == ("", "")
    assert caplog.messages == []


def test_fewer_times_than_markers(desk: Path) -> None:
    """Twenty places of 25 markers are twenty rows, as many as the clock has, though 25 is more."""
    place = np.random.default_rng(0).normal(size=(20, 25, 3))
    np.savez("t.npz", time=np.arange(20.0), pressure=np.repeat([0.0, 10, 30, 20], 5), position=place)
    guess = guess_mapping("t.npz")
    assert len(guess.mapping["observables"]) == 75
    run, _, _ = import_guessed([Path("t.npz")], Path("run"))
    assert run["observed"].to_numpy().reshape(20, 25, 3) == pytest.approx(place)
