"""What a person looks at: reports in HTML, recordings and the live view in rerun, still pictures."""

from typing import TYPE_CHECKING

from labrig._lazy import lazy

if TYPE_CHECKING:
    from labrig.view._colours import STEPS
    from labrig.view._course import write_course
    from labrig.view._experiment import PROMISES_KEPT, programme_figure, write_experiment, write_investigation
    from labrig.view._explorer import colour_legend, surface_explorer
    from labrig.view._fields import Skin, capture_words, cloud, filled, residuals, rms, skin
    from labrig.view._figures import Figure
    from labrig.view._history_figures import changed_pictures, history_pictures
    from labrig.view._history_report import history_headline, history_notes, write_history
    from labrig.view._ik_report import write_ik_report
    from labrig.view._investigation_figures import investigation_pictures
    from labrig.view._legend import legend_picture
    from labrig.view._live import LiveView, live_observers
    from labrig.view._names_in_space import name_places, proud
    from labrig.view._naming import (
        UNSEEN,
        added,
        astray,
        at_one_moment,
        confirmed_by,
        effect_rows,
        names_in_short,
        needed,
        none_surely,
        not_it,
        only_perhaps,
        possible,
        unseen_words,
    )
    from labrig.view._outlines import chamber_outlines
    from labrig.view._picture import write_picture
    from labrig.view._pictures import pictures_of
    from labrig.view._places import place_tables
    from labrig.view._predict import live_predict
    from labrig.view._recording import write_recording
    from labrig.view._report import write_report
    from labrig.view._scene import CHAMBER_COLOURS
    from labrig.view._style import ERROR_SCALE
    from labrig.view._surface_figure import surface_figure
    from labrig.view._target_figures import target_figures
    from labrig.view._training_report import (
        Table,
        forward_table,
        sim2real_table,
        write_forward_report,
        write_sim2real_report,
    )
    from labrig.view._validation_report import write_validation
    from labrig.view._values import fitted, value_lines, values_words
    from labrig.view._versus_report import versus_pictures, write_versus
    from labrig.view._versus_words import difference_words, interval_words, share_words, versus_headline
    from labrig.view._viewer import Viewer, screenshot, start_viewer
    from labrig.view._weight_names import shown_of
    from labrig.view._words import Lines, Note, much_left_out, note, summary_words

_LAZY = {
    "CHAMBER_COLOURS": "_scene",
    "ERROR_SCALE": "_style",
    "STEPS": "_colours",
    "Figure": "_figures",
    "Skin": "_fields",
    **dict.fromkeys(("capture_words", "cloud", "filled", "residuals", "rms", "skin"), "_fields"),
    "chamber_outlines": "_outlines",
    "colour_legend": "_explorer",
    "legend_picture": "_legend",
    "write_course": "_course",
    "surface_explorer": "_explorer",
    "name_places": "_names_in_space",
    "proud": "_names_in_space",
    "surface_figure": "_surface_figure",
    "UNSEEN": "_naming",
    "added": "_naming",
    "astray": "_naming",
    "at_one_moment": "_naming",
    "confirmed_by": "_naming",
    "none_surely": "_naming",
    "not_it": "_naming",
    "only_perhaps": "_naming",
    "possible": "_naming",
    "unseen_words": "_naming",
    "effect_rows": "_naming",
    "names_in_short": "_naming",
    "needed": "_naming",
    "fitted": "_values",
    "place_tables": "_places",
    "value_lines": "_values",
    "values_words": "_values",
    "shown_of": "_weight_names",
    "Lines": "_words",
    "LiveView": "_live",
    "Table": "_training_report",
    "forward_table": "_training_report",
    "sim2real_table": "_training_report",
    "write_forward_report": "_training_report",
    "write_sim2real_report": "_training_report",
    "Viewer": "_viewer",
    **dict.fromkeys(("changed_pictures", "history_pictures"), "_history_figures"),
    **dict.fromkeys(("history_headline", "history_notes", "write_history"), "_history_report"),
    "investigation_pictures": "_investigation_figures",
    "live_observers": "_live",
    "live_predict": "_predict",
    "Note": "_words",
    "much_left_out": "_words",
    "note": "_words",
    "pictures_of": "_pictures",
    "PROMISES_KEPT": "_experiment",
    "programme_figure": "_experiment",
    "screenshot": "_viewer",
    "start_viewer": "_viewer",
    "summary_words": "_words",
    "target_figures": "_target_figures",
    "has_improved": "_words",
    "difference_words": "_versus_words",
    "share_words": "_versus_words",
    "interval_words": "_versus_words",
    "versus_headline": "_versus_words",
    "versus_pictures": "_versus_report",
    "write_experiment": "_experiment",
    "write_ik_report": "_ik_report",
    "write_investigation": "_experiment",
    "write_picture": "_picture",
    "write_recording": "_recording",
    "write_report": "_report",
    "write_validation": "_validation_report",
    "write_versus": "_versus_report",
}

__all__ = [
    "CHAMBER_COLOURS",
    "ERROR_SCALE",
    "PROMISES_KEPT",
    "STEPS",
    "UNSEEN",
    "Figure",
    "Lines",
    "LiveView",
    "Note",
    "Skin",
    "Table",
    "Viewer",
    "added",
    "astray",
    "at_one_moment",
    "capture_words",
    "chamber_outlines",
    "changed_pictures",
    "cloud",
    "colour_legend",
    "confirmed_by",
    "difference_words",
    "effect_rows",
    "filled",
    "fitted",
    "forward_table",
    "history_headline",
    "history_notes",
    "history_pictures",
    "interval_words",
    "investigation_pictures",
    "legend_picture",
    "live_observers",
    "live_predict",
    "much_left_out",
    "name_places",
    "names_in_short",
    "needed",
    "none_surely",
    "not_it",
    "note",
    "only_perhaps",
    "pictures_of",
    "place_tables",
    "possible",
    "programme_figure",
    "proud",
    "residuals",
    "rms",
    "screenshot",
    "share_words",
    "shown_of",
    "sim2real_table",
    "skin",
    "start_viewer",
    "summary_words",
    "surface_explorer",
    "surface_figure",
    "target_figures",
    "unseen_words",
    "value_lines",
    "values_words",
    "versus_headline",
    "versus_pictures",
    "write_course",
    "write_experiment",
    "write_forward_report",
    "write_history",
    "write_ik_report",
    "write_investigation",
    "write_picture",
    "write_recording",
    "write_report",
    "write_sim2real_report",
    "write_validation",
    "write_versus",
]

__getattr__ = lazy(__name__, _LAZY)
