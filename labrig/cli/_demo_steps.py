"""The demo step by step: a rig with something hidden, a campaign, a diagnosis, a better model, pictures."""

import importlib.util
import os
import time
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, SpinnerColumn, TextColumn
from rich.table import Table

from labrig._errors import LabrigError
from labrig._near import meant
from labrig.cli._console import new_console
from labrig.cli._program import activation, call

if TYPE_CHECKING:
    from labrig.diagnosis import Result
    from labrig_drivers.simulated._sealed import HiddenSetting

CAPTURES = 40
CHAMBERS, MARKERS = 9, 34
HIGHEST = (
    0.75  # of each chamber's range: a hidden regulator may overshoot, and the rig vents 5 kPa above a limit
)
BAR = 30

RIG = f"""\
# A simulated rig: the front of a mannequin at half scale, {CHAMBERS} chambers, {MARKERS} markers. What the devices see
# is a finer mesh of it, of sheets and seams that are not quite as the model has them.
name: mannequin
chambers:
{"".join(f"  - {{name: c{i}, min_kpa: 0, max_kpa: 60, slew_kpa_s: 100}}{chr(10)}" for i in range(1, CHAMBERS + 1))}\
markers: [{", ".join(f"m{i:02d}" for i in range(1, MARKERS + 1))}]
pressure: {{kind: simulated}}
mocap: {{kind: simulated}}
follow: {{tolerance_kpa: 20, tolerance_share: 0.5}}  # what it hides may be a leak, which shall be named and not mended
simulated:
  shell: mannequin
  plant: {{count: [34, 34], seed: 0, spread: 0.15, vary: materials, shapes: 120}}
  seed: SEED
  noise_mm: 0.1
  occlusion: 0.03
  hidden: sealed.json
"""

MODEL = """\
# What is believed of the rig: the simulator, with the stiffness of its two sheets as it was calibrated when the rig was
# new, and no effects yet.
base: {kind: simulator, rig: rig.yaml, parameters: {modulus_1_kpa: 541, modulus_2_kpa: 564}}
effects: []
"""


def run_demo(hide: str, seed: int, out: Path) -> Path:
    """The whole demo, with what it does printed; returns the folder that it made."""
    # The matrices are small: on a busy computer more threads would only wait for each other.
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    console = new_console(highlight=False)
    hidden = _hidden(hide, seed)
    began = time.monotonic()
    folder = _new_folder(out)
    _prepare(folder, seed, hidden)
    what = (
        "nothing that its model lacks"
        if hide == "nothing"
        else hide or "something, and nobody has looked what"
    )
    console.print(f"A simulated rig hides {what} (seed {seed}).")
    _campaign(console, folder, seed)
    result, final = _diagnosis(console, folder)
    _pictures(console, folder, result)
    console.print()
    console.print(_waterfall(console, final))
    _closing(console, folder, result, time.monotonic() - began)
    return folder


def _hidden(hide: str, seed: int) -> "HiddenSetting":
    """The setting of the simulated rig; raises `LabrigError` for an effect that does not exist."""
    from labrig_drivers.simulated import choose
    from labrig_drivers.simulated import hide as hide_effect
    from labrig_drivers.simulated.hidden import EFFECTS

    if not hide:
        return choose(seed)
    if hide != "nothing" and hide not in EFFECTS:
        raise LabrigError(
            f"--hide: there is no effect '{hide}'; choose nothing, {', '.join(EFFECTS)}{meant(hide, EFFECTS)}"
        )
    return hide_effect(hide, seed=seed)


def _new_folder(out: Path) -> Path:
    """Make `out`, or the first of out-2, out-3, ... that does not exist yet."""
    for number in range(1, 10_000):
        folder = out if number == 1 else out.with_name(f"{out.name}-{number}")
        try:
            folder.mkdir(parents=True)
        except FileExistsError:
            continue
        except OSError as error:
            raise LabrigError(f"cannot make the folder {folder}: {error.strerror or error}") from None
        return folder
    raise LabrigError(f"{out} and ten thousand names like it exist; name another folder with --out")


def _prepare(folder: Path, seed: int, hidden: "HiddenSetting") -> None:
    from labrig_drivers.simulated import seal

    (folder / "rig.yaml").write_text(RIG.replace("SEED", str(seed)), encoding="utf-8")
    (folder / "model.yaml").write_text(MODEL, encoding="utf-8")
    seal(folder, hidden)


def _campaign(console: Console, folder: Path, seed: int) -> None:
    from labrig.campaign import run
    from labrig.rig import connect, load_rig
    from labrig_drivers import SimulatedClock
    from labrig_procedures import Capture

    clock = SimulatedClock()
    start_s, began = clock.now_s(), time.monotonic()
    columns = (SpinnerColumn(), TextColumn("{task.description}"), BarColumn(BAR), MofNCompleteColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as progress:
        task = progress.add_task("campaign ", total=CAPTURES)
        with connect(load_rig(folder / "rig.yaml"), clock) as rig:
            run(
                Capture.model_validate({"captures": CAPTURES, "highest": HIGHEST}),
                rig,
                folder / "run",
                clock=clock,
                seed=seed,
                progress=lambda seen: progress.update(task, completed=seen.captures_done),
            )
    _say(
        console,
        "campaign",
        f"{CAPTURES} captures of {MARKERS} markers, {(clock.now_s() - start_s) / 60:.1f} min on the rig's clock, "
        f"logged to {folder / 'run'} in {time.monotonic() - began:.0f} s",
    )


def _diagnosis(console: Console, folder: Path) -> "tuple[Result, Result]":
    """Compare, diagnose and improve, as the commands of these names do; the diagnosis, and what stands in the end.

    A diagnosis weighs what is only possible as well, so its error is not that of the model which improve writes.
    """
    with console.status("comparing"):
        import labrig
        from labrig._json import write_json
        from labrig.diagnosis import compare, diagnose, improve
        from labrig.model import Model
        from labrig.view import summary_words

        model, run = Model.load(folder / "model.yaml"), labrig.open_run(folder / "run")
        compared = compare(run, model).summary
        write_json(compared, folder / "compare.json")
    _say(console, "compare", summary_words(compared).headline)
    with console.status("diagnosing"):
        result = diagnose(run, model)
        result.write(folder / "diagnosis.json")
    said = summary_words(result.summary)
    _say(console, "diagnose", said.found)
    if said.unnamed:
        _say(console, "", said.unnamed)
    if result.summary["verdict"] not in ("identified", "multiple"):
        _say(console, "improve", "nothing is added: the model stays as it is")
        return result, result
    with console.status("improving"):
        better = improve(run, model, result.summary["effects"])
        path = folder / "model.improved.yaml"
        if better.improved is not None:
            better.improved.save(path)
    _say(console, "improve", summary_words(better.summary).headline)
    _say(console, "", f"The model with it is {path}.")
    return result, better


def _pictures(console: Console, folder: Path, result: "Result") -> None:
    with console.status("drawing"):
        from labrig.view import write_recording, write_report

        write_report(result, folder)
        write_recording(result, folder / "demo.rrd")


def _say(console: Console, step: str, text: str) -> None:
    console.print(f"  {step:<9} {text}", soft_wrap=True)


def _waterfall(console: Console, result: "Result") -> Table:
    """From the base to the floor, with a bar each."""
    units = str(result.summary["units"])
    table = Table(box=None, pad_edge=True)
    table.add_column("held-out error")
    table.add_column(units, justify="right")
    table.add_column("")
    block = "#" if console.options.ascii_only else "█"
    top = max(value for _, value in result.waterfall) or 1.0
    for label, value in result.waterfall:
        table.add_row(label.replace("_", " "), f"{value:.3g}", block * max(1, round(BAR * value / top)))
    return table


def _closing(console: Console, folder: Path, result: "Result", took_s: float) -> None:
    from labrig.view import summary_words

    console.print()
    console.print(summary_words(result.summary).headline, style="bold", soft_wrap=True)
    console.print(f"Done in {took_s:.0f} s. Look at it, watch it, and open what was sealed:", soft_wrap=True)
    console.print(f"  {(folder / 'report.html').resolve()}", soft_wrap=True)
    console.print(f"  {call('view', folder)}", soft_wrap=True, markup=False)
    console.print(f"  {call('reveal', folder / 'run')}", soft_wrap=True, markup=False)
    if line := activation():
        console.print("So that `labrig` alone works in this terminal:", soft_wrap=True)
        console.print(f"  {line}", soft_wrap=True, markup=False)
    if importlib.util.find_spec("starlette") and importlib.util.find_spec("uvicorn"):
        console.print("Go through it by clicks, in the browser:", soft_wrap=True)
        console.print(f"  {call('workbench', folder)}", soft_wrap=True, markup=False)
