"""What a person looks at: reports in HTML, recordings and the live view in rerun, still pictures."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from labrig.view._experiment import programme_figure, write_experiment, write_investigation
    from labrig.view._explorer import colour_legend, surface_explorer
    from labrig.view._ik_report import write_ik_report
    from labrig.view._investigation_figures import investigation_pictures
    from labrig.view._legend import legend_picture
    from labrig.view._live import LiveView, live_observers
    from labrig.view._naming import effect_rows, names_in_short
    from labrig.view._outlines import chamber_outlines
    from labrig.view._picture import write_picture
    from labrig.view._pictures import pictures_of
    from labrig.view._predict import live_predict
    from labrig.view._recording import write_recording
    from labrig.view._report import write_report
    from labrig.view._surface_figure import surface_figure
    from labrig.view._training_report import (
        Table,
        forward_table,
        sim2real_table,
        write_forward_report,
        write_sim2real_report,
    )
    from labrig.view._validation_report import write_validation
    from labrig.view._values import value_lines
    from labrig.view._viewer import Viewer, screenshot, start_viewer
    from labrig.view._words import Lines, Note, note, summary_words

_LAZY = {
    "chamber_outlines": "_outlines",
    "colour_legend": "_explorer",
    "legend_picture": "_legend",
    "surface_explorer": "_explorer",
    "surface_figure": "_surface_figure",
    "effect_rows": "_naming",
    "names_in_short": "_naming",
    "value_lines": "_values",
    "Lines": "_words",
    "LiveView": "_live",
    "Table": "_training_report",
    "forward_table": "_training_report",
    "sim2real_table": "_training_report",
    "write_forward_report": "_training_report",
    "write_sim2real_report": "_training_report",
    "Viewer": "_viewer",
    "investigation_pictures": "_investigation_figures",
    "live_observers": "_live",
    "live_predict": "_predict",
    "Note": "_words",
    "note": "_words",
    "pictures_of": "_pictures",
    "programme_figure": "_experiment",
    "screenshot": "_viewer",
    "start_viewer": "_viewer",
    "summary_words": "_words",
    "write_experiment": "_experiment",
    "write_ik_report": "_ik_report",
    "write_investigation": "_experiment",
    "write_picture": "_picture",
    "write_recording": "_recording",
    "write_report": "_report",
    "write_validation": "_validation_report",
}

__all__ = [
    "Lines",
    "LiveView",
    "Note",
    "Table",
    "Viewer",
    "chamber_outlines",
    "colour_legend",
    "effect_rows",
    "forward_table",
    "investigation_pictures",
    "legend_picture",
    "live_observers",
    "live_predict",
    "names_in_short",
    "note",
    "pictures_of",
    "programme_figure",
    "screenshot",
    "sim2real_table",
    "start_viewer",
    "summary_words",
    "surface_explorer",
    "surface_figure",
    "value_lines",
    "write_experiment",
    "write_forward_report",
    "write_ik_report",
    "write_investigation",
    "write_picture",
    "write_recording",
    "write_report",
    "write_sim2real_report",
    "write_validation",
]


def __getattr__(name: str) -> Any:
    if name in _LAZY:
        return getattr(import_module(f"labrig.view.{_LAZY[name]}"), name)
    raise AttributeError(f"module 'labrig.view' has no attribute {name!r}")
