"""How a run ended, as somebody in the lab reads it: the log has the word of whoever ended it, such as a signal's."""

from labrig.catalogue import Row
from labrig.log import RunSummary

_BY = {
    "Ctrl-C": "ended by Ctrl-C in its terminal, or by cancel in the list of jobs",
    "Ctrl-Break": "ended by Ctrl-Break in its terminal, or by cancel in the list of jobs",
    "SIGTERM": "ended by another program or a shutdown (SIGTERM)",
    "SIGHUP": "ended as its terminal was closed (SIGHUP)",
    "the workbench": "ended by End in the workbench",
    "the vent button": "ended by the vent button",
    "labrig rig vent": "ended by a vent in a terminal (labrig rig vent)",
    "another process on this computer": "ended by another program on this computer",
}
"""Where one of these stands in the log, the vent was confirmed before."""


def said(state: str) -> str:
    """Who ended a run, where its state says no more than that; any other state as it is."""
    return _BY.get(state, state)


def conclusion_said(text: str) -> str:
    """What an investigation says that was interrupted, with who ended its run."""
    reason = next((each for each in _BY if f"stopped by {each} after " in text), None)
    return text if reason is None else text.replace(f"stopped by {reason} after ", f"{_BY[reason]} after ")


def row_said(row: Row) -> Row:
    """A row of the catalogue whose state says who ended the run, and that it was vented."""
    return row._replace(state=f"{_BY[row.state]}; vented") if row.state in _BY else row


def events_said(summary: RunSummary, last: int) -> list[tuple[float, str]]:
    """The last events; those that say who ended the run, or a part of one that was gone on with, in words."""
    return [(time_s, said(text)) for time_s, text in summary.events[-last:]]
