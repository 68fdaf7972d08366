"""The report of `labrig history`: an HTML page of what changed, when, and how everything went over the runs."""

from collections import Counter
from html import escape
from pathlib import Path

from labrig.contents import HistoryChange, HistoryContent
from labrig.view._experiment import _over, _warnings, _write
from labrig.view._history_figures import history_pictures
from labrig.view._history_picture import write_history_picture
from labrig.view._page import Page, table
from labrig.view._style import AFTER, BEFORE

PICTURE_NAME = "history.png"
_TITLES = {
    "effects": ("Effects", "Each effect of the model, fitted anew to every run: 1 is what the model has."),
    "softness": (
        "Softness",
        "How far everything moves, beside the effects: rubber softens with warmth and use.",
    ),
    "error": ("Error and noise", "What the model as it stands leaves, and what repeats differ by."),
    "leaks": ("Leaks", "How fast each chamber loses pressure while it is held."),
    "zeros": ("Pressure zeros", "What each sensor reads at rest."),
    "markers": ("Markers", "Each marker at rest, without what all of them do together."),
    "cameras": ("Cameras", "What all markers do together, as a shift."),
    "lost": ("Markers lost", "The share of marker frames in which a marker was not seen."),
    "ambient": ("Ambient", "What else was logged. It is shown, and never counts as a change of the rig."),
}
_TOLD_FIRST = ("leak", "marker", "frame", "effect", "zero", "gain", "lost", "floor", "error")
"""Groups of changes, what says most about its cause first: everything raises the error."""
_FEWEST_ALIKE = 7
"""Runs of one programme from which on a huge step, anywhere but in the last run, is sure among 500 quantities; of six
none is, however large."""


def write_history(content: HistoryContent, folder: Path) -> Path:
    """Write report.html and history.png of a history (the content of history.json); returns the report's path."""
    folder.mkdir(parents=True, exist_ok=True)
    page = Page(f"labrig: the history of {content['rig']}")
    runs, changes = content["runs"], content["changes"]
    between = f"{runs[0]['date'][:10]} to {runs[-1]['date'][:10]} UTC" if runs else ""
    _over(
        page,
        "changed" if changes else "as it was",
        BEFORE if changes else AFTER,
        [_runs(len(runs)), between],
    )
    page.add(f"<h1>{escape(history_headline(content))}</h1>")
    _warnings(page, history_notes(content))
    if changes:
        page.section(
            "What changed",
            f"By chance none of these in {1 / content['alpha']:.0f} histories, if runs scatter independently.",
        )
        header = ["what", "begins, UTC", "earliest", "latest", "noticed"]
        page.add(table(header, [_row(change) for change in changes]))
    for name, figure in history_pictures(content).items():
        page.section(*_TITLES[name])
        page.add(page.plot(figure()))
    path = _write(page, folder)
    write_history_picture(content, folder / PICTURE_NAME)
    return path


def history_headline(content: HistoryContent) -> str:
    """What came out, in a sentence."""
    changes, count = content["changes"], len(content["runs"])
    if not changes:
        alike = _most_alike(content)
        if alike >= _FEWEST_ALIKE:
            return f"Nothing on {content['rig']} has changed by more than chance in {_runs(count)}."
        which = f", at most {alike} of them of the same programme" if alike < count else ""
        return (
            f"{_runs(count)} of {content['rig']}{which}: nothing can be told yet, "
            "a change shows from the seventh run of a programme on."
        )
    said = str(min(reversed(changes), key=lambda change: _TOLD_FIRST.index(change["group"]))["words"])
    others = f", and {len(changes) - 1} more" if len(changes) > 1 else ""
    return (
        f"{'T' + said[1:] if said.startswith('the ') else said}{others}."  # names of markers stay as they are
    )


def _most_alike(content: HistoryContent) -> int:
    """How many runs there are of the programme that was run most often: only runs of the same one can be compared."""
    return max(Counter(run["kind"] for run in content["runs"]).values(), default=0)


def _runs(count: int) -> str:
    return "1 run" if count == 1 else f"{count} runs"


def history_notes(content: HistoryContent) -> list[str]:
    """What to keep in mind: runs that were left out, and what one run shows that no other confirms."""
    notes = [f"{each['run']} is left out: {each['why']}" for each in content["left_out"]]
    kinds = [run["kind"] for run in content["runs"]]
    if len(kinds) > 1 and kinds.count(kinds[-1]) == 1:
        notes.append(
            f"the last run is the first of its programme ({content['runs'][-1]['procedure']}): there is none before it "
            "that it could be compared with"
        )
    if content["unconfirmed"]:
        notes.append(
            f"the last run alone shows a change, one more will tell: {', '.join(content['unconfirmed'])}"
        )
    return notes


def _row(change: HistoryChange) -> list[str]:
    since = " (after the model was fitted)" if change["since_fit"] else ""
    dates = [change[name][:10] for name in ("date", "earliest", "latest", "noticed_date")]
    return [escape(change["words"] + since), *map(escape, dates)]
