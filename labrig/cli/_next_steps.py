"""What `labrig next` does: propose, check by a dry run, write the procedure file, say why."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import typer
import yaml
from rich.console import Console
from rich.table import Table

from labrig._errors import LabrigError
from labrig.cli._places import check_file, check_folder, replaced

if TYPE_CHECKING:
    from labrig.campaign import Plan
    from labrig.experiment import Experiment, Limits
    from labrig.rig import RigConfig


def do_next(
    runs: Sequence[Path],
    model: Path,
    rig: Path,
    output: Path,
    minutes: float,
    tolerance: float | None,
    force: bool,
    out: Path,
) -> None:
    """Write the procedure that settles what the diagnosis of the runs leaves open, and print why this one."""
    import labrig
    from labrig.diagnosis import diagnose, write_json
    from labrig.experiment import propose_experiment
    from labrig.model import Model
    from labrig.rig import load_rig
    from labrig.view import write_experiment

    if output.suffix not in {".yaml", ".yml"}:
        raise LabrigError(f"{output}: a procedure file ends in .yaml")
    if output.exists() and not force:
        raise LabrigError(f"{output} exists; choose another name, or overwrite it with --force")
    check_file(output)
    check_folder(out)
    config = load_rig(rig)
    opened = [labrig.open_run(run) for run in runs]
    for name, run in zip(runs, opened, strict=True):
        check_rig(config, rig, run, name)
    questioned = Model.load(model)
    summary = diagnose(opened, questioned, tolerance=tolerance).summary
    experiment = propose_experiment(
        opened, questioned, summary=summary, limits=limits_of(config), minutes=minutes, tolerance=tolerance
    )
    plan = checked_plan(experiment, config)
    report = {
        **experiment.summary,
        "minutes": plan.duration_s / 60,
        "procedure": str(output),
        "rig": config.name,
    }
    of_procedure, of_report = replaced(output), replaced(out / "report.html")
    write_procedure(experiment, config, output)
    out.mkdir(parents=True, exist_ok=True)
    write_json(report, out / "next.json")
    page = write_experiment(report, experiment.programme(), out)
    print_experiment(report)
    typer.echo(f"procedure: {output}{of_procedure}")
    typer.echo(f"report: {page}{of_report}")
    typer.echo(f"to run it: labrig run {output} --rig {rig} --dry-run")


def limits_of(config: "RigConfig") -> "Limits":
    """What a rig allows, as the search for a programme takes it."""
    from labrig.experiment import Limits

    chambers = config.chambers
    return Limits(
        np.array([c.min_kpa for c in chambers]),
        np.array([c.max_kpa for c in chambers]),
        np.array([c.slew_kpa_s for c in chambers]),
    )


def check_rig(config: "RigConfig", rig: Path, run: Any, name: Path) -> None:
    """Raise `LabrigError` if a rig is not the one of a run."""
    chambers = [str(c) for c in run["chamber"].values]
    own = [c.name for c in config.chambers]
    if own != chambers:
        raise LabrigError(
            f"{rig}: its chambers ({', '.join(own)}) are not those of {name} ({', '.join(chambers)})"
        )
    unit = str(run["commanded"].attrs.get("units", ""))
    if unit != "kPa":
        raise LabrigError(f"{name}: its actuation is in {unit or 'no unit'}; a rig's is in kPa")


def checked_plan(experiment: "Experiment", config: "RigConfig") -> "Plan":
    """The dry run of the programme; raises `LabrigError` if it would break a limit."""
    from labrig.campaign import dry_run
    from procedures import Programme

    plan = dry_run(Programme.model_validate({"points": experiment.programme()}), config)
    if plan.broken:
        raise LabrigError(f"the proposed programme would break a limit: {plan.broken[0]}")
    return plan


def write_procedure(experiment: "Experiment", config: "RigConfig", path: Path) -> None:
    """Write the programme as a procedure file, in one piece or not at all."""
    summary = experiment.summary
    separates = ", ".join(summary["separates"]) or "what is open"
    lines = [
        f"# Written by labrig next for rig {config.name}: separates {separates}.",
        f"# Why: {summary['why']}.",
        f"# labrig run {path.name} --rig RIG.yaml --dry-run",
        "procedure: programme",
        "points:",
    ]
    lines += [f"- {_flow(point)}" for point in experiment.programme()]
    partial = path.with_name(path.name + ".part")
    partial.write_text("\n".join(lines) + "\n", encoding="utf-8")
    partial.replace(path)


def _flow(point: dict[str, Any]) -> str:
    return yaml.safe_dump(
        point, default_flow_style=True, sort_keys=False, width=10_000, allow_unicode=True
    ).strip()


def print_experiment(report: dict[str, Any]) -> None:
    """The table of probes, what it is expected to say, and why this programme."""
    console = Console(highlight=False)
    console.print(
        f"verdict: {report['verdict']}; to separate: {', '.join(report['separates']) or 'what is open'}"
    )
    named = bool(report["expected"])
    last = "difference" if named else "information"
    table = Table("probe", "shows", "separates", "times", last, "min", title=f"{report['captures']} captures")
    for probe in report["probes"]:
        amount = f"{probe['floors']:.2g} floors" if named else f"{probe['nats']:.2g} nats"
        table.add_row(
            probe["probe"],
            probe["shows"],
            probe["separates"],
            str(probe["times"]),
            amount,
            f"{probe['minutes']:.1f}",
        )
    console.print(table)
    if named:
        expected = Table(
            "if it is", "would be off by", "", "settles", title="fitted again to the run and to this"
        )
        for each in report["expected"]:
            off = f"{each['apart']:.2g} {report['units']} ({each['floors']:.2g} floors)"
            expected.add_row(each["true"], each["other"], off, "yes" if each["settles"] else "perhaps")
        console.print(expected)
    console.print(f"why this one: {report['why']}", soft_wrap=True)
    console.print(f"takes {report['minutes']:.1f} min")
    for hand in report["by_hand"]:
        console.print(f"by hand, for {hand['effect']}: {hand['what']}", soft_wrap=True)
    for warning in report["warnings"]:
        console.print(f"note: {warning}", soft_wrap=True)
