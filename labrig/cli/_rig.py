"""Commands: rig check, vent, simulate, record, replay."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from labrig._durable import put_at
from labrig.cli._app import app
from labrig.cli._group import Group
from labrig.cli._places import check_folder
from labrig.cli._signals import ending_on_signals

if TYPE_CHECKING:
    from threading import Event

    from labrig_drivers import Finding
    from labrig_drivers.simulated._twins import TwinFile

rig_app = typer.Typer(
    name="rig",
    help="Try a rig's devices, simulate them on local ports, record and replay what they say.",
    cls=Group,
)
app.add_typer(rig_app)

_ON_A_WIRE = ("openpneu", "modbus", "vicon")
"""Kinds of devices whose bytes can be recorded."""

_WRITTEN = "# Written by `labrig rig {command}`: reaches the devices that it started.\n"


@rig_app.command()
def check(
    rig: Annotated[Path, typer.Argument(metavar="RIG", help="The rig file.")],
    read_s: Annotated[float, typer.Option("--read-s", min=0.1, max=3600, help="How long to read, s.")] = 2.0,
    still: Annotated[bool, typer.Option("--still", help="Fill no chamber: only read, and vent.")] = False,
    model: Annotated[
        Path | None, typer.Option(help="A model to tell by the markers whether tubes are swapped.")
    ] = None,
) -> None:
    """Connect to every device of RIG, read it, try the vent, fill each chamber in turn, and say what is well.

    Each chamber is filled alone to half of its limit, which finds tubes that are off or swapped, leaks, and sensors
    whose zero or scale is wrong. It takes 5 to 15 s a chamber; --still leaves it out.
    """
    from labrig.cli._rig_steps import check_chambers
    from labrig.rig import device_makers, in_use, load_rig
    from labrig_drivers import RealClock, check_devices

    config = load_rig(rig)
    with in_use(config, "labrig rig check"):
        makers = device_makers(config, RealClock())
        findings = check_devices(makers, read_s, config.safety.vent_timeout_s)
        if not still and not any(f.state == "bad" for f in findings if f.device == "pressure"):
            findings += check_chambers(config, model, lambda text: typer.echo(f"labrig: {text}", err=True))
    _print_findings(config.name, findings)
    if any(finding.state == "bad" for finding in findings):
        raise typer.Exit(3)


@rig_app.command()
def vent(rig: Annotated[Path, typer.Argument(metavar="RIG", help="The rig file.")]) -> None:
    """Vent RIG now, also while a run goes on, which ends then; say what every chamber reads."""
    from labrig.rig import load_rig, vent_now

    config = load_rig(rig)
    vented = vent_now(config, "labrig rig vent", lambda text: typer.echo(f"labrig: {text}; again", err=True))
    for name, pressure_kpa in vented.pressure_kpa.items():
        typer.echo(f"{name:12} {'no sensor' if pressure_kpa is None else f'{pressure_kpa:6.2f} kPa'}")
    typer.echo(f"vented in {vented.took_s:.1f} s by {vented.by}")


@rig_app.command()
def simulate(
    out: Annotated[Path, typer.Option("-o", "--out", help="Folder for rig.yaml and scans.")] = Path(
        "simulated-rig"
    ),
    rig: Annotated[
        Path | None, typer.Option("--rig", help="A rig file whose chambers and `simulated` section to use.")
    ] = None,
    surface: Annotated[
        str,
        typer.Option(help="Without --rig: a reduced surface, mannequin or membrane, in place of the shell."),
    ] = "",
    seed: Annotated[int, typer.Option(help="Seed of noise and occlusion, when no --rig is given.")] = 0,
    pressure: Annotated[
        str, typer.Option(help="openpneu, openpneu-table (the other dialect) or modbus.")
    ] = "openpneu",
    build: Annotated[
        str, typer.Option(help="OpenPneu firmware: full, or published with its quirks.")
    ] = "full",
    register_map: Annotated[
        str, typer.Option("--map", help="Register map of the modbus twin.")
    ] = "festo-vtem.yaml",
    pty: Annotated[
        bool, typer.Option(help="OpenPneu on a pseudo terminal instead of a TCP port (not Windows).")
    ] = False,
    host: Annotated[
        str, typer.Option(help="Address to listen on; others can reach you if you change it.")
    ] = "127.0.0.1",
    pressure_port: Annotated[int, typer.Option(min=0, max=65535, help="0: a free one.")] = 0,
    mocap_port: Annotated[
        int, typer.Option(min=0, max=65535, help="0: a free one (Vicon's own is 801).")
    ] = 0,
    rate_hz: Annotated[float, typer.Option(min=1, max=1000, help="Motion capture frames a second.")] = 100.0,
    up: Annotated[str, typer.Option(help="The axis that the motion capture server calls up: z or y.")] = "z",
    scan_every_s: Annotated[float, typer.Option(min=0.1, help="Export a scan this often, s.")] = 10.0,
    scan_unit: Annotated[str, typer.Option(help="Unit of the exported scans: mm, cm, m or inch.")] = "mm",
    seconds: Annotated[
        float | None, typer.Option(min=0, help="End after this long, s; otherwise on Ctrl-C.")
    ] = None,
) -> None:
    """Start devices that speak the real wire protocols, and write the rig.yaml that reaches them."""
    from labrig_drivers import RealClock
    from labrig_drivers.simulated import build_plant
    from labrig_drivers.simulated._twins import PRESSURE_KINDS, TwinOptions, TwinRig

    _one_of("pressure", pressure, PRESSURE_KINDS)
    _one_of("build", build, ("full", "published"))
    _one_of("up", up, ("z", "y"))
    _one_of("scan-unit", scan_unit, ("mm", "cm", "m", "inch"))
    check_folder(out, "-o")
    _not_somebodys(out / "rig.yaml")
    content, folder = _simulated_rig(rig, surface, seed)
    options = TwinOptions(
        host=host,
        pressure=pressure,
        pressure_port=pressure_port,
        mocap_port=mocap_port,
        build=build,  # type: ignore[arg-type]
        register_map=register_map,
        pty=pty,
        rate_hz=rate_hz,
        up=up,
        scan_every_s=scan_every_s,
        scan_unit=scan_unit,
    )
    plant = build_plant(content, folder)
    plant.make_ready()  # minutes where nothing is kept yet: nobody is told to connect before
    name = str(content["name"])
    with ending_on_signals() as ended, TwinRig(plant, name, out, RealClock(), options) as twins:
        file = _write_rig(out, twins.rig, "simulate")
        _say(file, twins.listening)
        _wait(ended, seconds)


@rig_app.command()
def record(
    rig: Annotated[Path, typer.Argument(metavar="RIG", help="The rig file.")],
    out: Annotated[Path, typer.Option("-o", "--out", help="New folder for the recording.")],
    seconds: Annotated[float, typer.Option(min=0.1, help="How long to record, s.")] = 10.0,
) -> None:
    """Read RIG's devices for a while, vent, and keep every byte that passes, for `labrig rig replay`."""
    from labrig._errors import LabrigError
    from labrig.rig import in_use, load_rig
    from labrig_drivers import RealClock

    config = load_rig(rig)
    check_folder(out, "-o")
    if out.exists() and any(out.iterdir()):
        raise LabrigError(f"{out} is not empty: record into a new folder")
    content = _recorded_rig(config)
    with in_use(config, "labrig rig record"):
        out.mkdir(parents=True, exist_ok=True)
        _record_session(config, out, RealClock(), seconds)
    file = _write_rig(out, content, "record")
    typer.echo(f"recorded into {out}; `labrig rig replay {out}` answers from it ({file.name} is its rig)")


@rig_app.command()
def replay(
    recording: Annotated[
        Path, typer.Argument(metavar="RECORDING", help="A folder that `labrig rig record` wrote.")
    ],
    out: Annotated[Path, typer.Option("-o", "--out", help="Folder for the rig.yaml.")] = Path("replayed-rig"),
    host: Annotated[str, typer.Option(help="Address to listen on.")] = "127.0.0.1",
    speed: Annotated[float, typer.Option(min=0.01, max=1000, help="2 plays twice as fast.")] = 1.0,
    seconds: Annotated[
        float | None, typer.Option(min=0, help="End after this long, s; otherwise on Ctrl-C.")
    ] = None,
) -> None:
    """Answer on local ports as the recorded devices did, and write the rig.yaml that reaches them."""
    from contextlib import ExitStack

    from labrig._errors import LabrigError
    from labrig.rig import load_rig
    from labrig_drivers import RecordingError
    from labrig_drivers.simulated._replay import ReplayTwin

    check_folder(out, "-o")
    if not (recording / "rig.yaml").is_file():
        raise LabrigError(f"{recording} holds no recording: `labrig rig record` makes one")
    content = load_rig(recording / "rig.yaml").to_dict()
    content.pop("safety", None)
    listening: dict[str, str] = {}
    with ending_on_signals() as ended, ExitStack() as stack:
        for role in ("pressure", "mocap"):
            file = recording / f"{role}.wire"
            if not file.is_file():
                continue
            try:
                twin = ReplayTwin(file, host=host, speed=speed).start()
            except RecordingError as error:
                raise LabrigError(str(error)) from None
            stack.callback(twin.stop)
            listening[role] = f"{file} on {host}:{twin.port}"
            content[role] |= _address(content[role]["kind"], host, twin.port)
        if not listening:
            raise LabrigError(f"{recording} holds no recording: `labrig rig record` makes one")
        _say(_write_rig(out, content, "replay"), listening)
        _wait(ended, seconds)


def _address(kind: str, host: str, port: int) -> dict[str, str | int]:
    if kind == "openpneu":
        return {"port": f"socket://{host}:{port}"}
    return {"host": host, "port": port}


def _simulated_rig(rig: Path | None, surface: str, seed: int) -> tuple[dict[str, Any], Path]:
    if rig is None:
        reduced = {"surface": surface} if surface else {}
        return {"name": surface or "mannequin", "simulated": {**reduced, "seed": seed}}, Path()
    from labrig._errors import LabrigError
    from labrig.rig import load_rig

    config = load_rig(rig)
    if config.simulated is None:
        raise LabrigError(f"{rig}: a section `simulated` is needed (seed, noise_mm, ...) to simulate it")
    return config.to_dict(), config.folder


def _recorded_rig(config: Any) -> dict[str, Any]:
    from labrig._errors import LabrigError

    if not any(device and device.kind in _ON_A_WIRE for device in config.devices.values()):
        kinds = ", ".join(dict.fromkeys(device.kind for device in config.devices.values() if device))
        raise LabrigError(
            f"rig {config.name}: of its devices ({kinds}) no bytes can be recorded, only of {', '.join(_ON_A_WIRE)}"
        )
    content = config.to_dict()
    content.pop("scanner", None)  # a scanner is a folder of files: they are their own recording
    return content


def _record_session(config: Any, out: Path, clock: Any, seconds: float) -> None:
    import time

    from labrig.rig import driver_limits
    from labrig_drivers import build_device

    devices: dict[str, Any] = {}
    try:
        for role, device in config.devices.items():
            if device is None or device.kind not in _ON_A_WIRE:
                continue
            devices[role] = build_device(
                device.kind,
                {**driver_limits(config, role), **device.options},
                name=role,
                clock=clock,
                channels=config.channels,
                marker_names=config.markers,
                base=config.folder,
                record=out / f"{role}.wire",
            )
            devices[role].connect()
            devices[role].identify()
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            for role, device in devices.items():
                device.samples() if role == "pressure" else device.frames()
            time.sleep(0.05)
        if "pressure" in devices:
            devices["pressure"].vent(config.safety.vent_timeout_s)
    finally:
        for device in devices.values():
            device.close()


def _not_somebodys(file: Path) -> None:
    """Raise `LabrigError` for a rig file that a person wrote."""
    from labrig._errors import LabrigError

    if file.exists() and not file.read_text(encoding="utf-8").startswith("# Written by `labrig rig "):
        raise LabrigError(f"{file} is somebody's own: choose another folder with -o")


def _write_rig(out: Path, content: "dict[str, Any] | TwinFile", command: str) -> Path:
    import yaml

    out.mkdir(parents=True, exist_ok=True)
    file = out / "rig.yaml"
    head = _WRITTEN.format(command=command)
    _not_somebodys(file)
    text = head + yaml.safe_dump(content, sort_keys=False, allow_unicode=True, default_flow_style=None)
    temporary = file.with_suffix(".yaml.part")
    temporary.write_text(text, encoding="utf-8")
    put_at(temporary, file)
    return file


def _say(file: Path, listening: dict[str, str]) -> None:
    for role, text in listening.items():
        typer.echo(f"{role:9} {text}")
    typer.echo(f"rig       {file}   (try: labrig rig check {file})")
    typer.echo("ready; Ctrl-C ends it")


def _wait(ended: "Event", seconds: float | None) -> None:
    import time

    end = float("inf") if seconds is None else time.monotonic() + seconds
    while not ended.is_set() and (left_s := end - time.monotonic()) > 0:
        ended.wait(min(left_s, 0.2))
    typer.echo("ended")


def _one_of(option: str, value: str, allowed: tuple[str, ...]) -> None:
    if value not in allowed:
        raise typer.BadParameter(f"{value!r} is none of {', '.join(allowed)}", param_hint=f"--{option}")


def _print_findings(name: str, findings: "list[Finding]") -> None:
    from rich.table import Table

    from labrig.cli._console import new_console

    table = Table(title=f"rig {name}", title_justify="left")
    for column in ("device", "looked at", "", "seen"):
        table.add_column(column, overflow="fold")
    for finding in findings:
        mark = {"well": "[green]well[/]", "look": "[yellow]look[/]", "bad": "[red]NOT WELL[/]"}[finding.state]
        table.add_row(finding.device, finding.what, mark, finding.text.replace("[", "\\["))
    new_console(highlight=False).print(table)
    for finding in [finding for finding in findings if finding.state == "bad"]:
        typer.echo(f"labrig: {finding.device}: {finding.what}: {finding.text}", err=True)
