"""The rooms of the report that go effect by effect: sure, possible or not it, and what each does by itself."""

from collections.abc import Mapping
from html import escape
from typing import TYPE_CHECKING

from labrig._text import capital, counted, number, word
from labrig.contents import Ranked, Summary
from labrig.effects import Fitted, library
from labrig.view._fields import most_moved_by
from labrig.view._naming import added, effect_rows, not_it, unseen_words
from labrig.view._page import Page, bar, table
from labrig.view._places import place_tables
from labrig.view._values import fitted, plain, values_words
from labrig.view._weight_names import shown_of

if TYPE_CHECKING:
    from labrig.diagnosis import Result

FEW_ROWS, FIRST_ROWS = 12, 6
_ABOUT = (
    "The probability of each effect, given all others (sure from 75 %, possible from 10 %: how often such a name was "
    "there), and its size if it is there: root mean square over the run, also as so many times the noise of one "
    "capture's mean (the floor above is that of a single row)."
)


def considered(page: Page, result: "Result") -> None:
    """Every effect of the library: sure, possible, or not it."""
    summary = result.summary
    rows = effect_rows(summary) if summary.get("verdict") and summary.get("effects_considered") else []
    if not rows:
        return
    page.section("Effect by effect", _ABOUT)
    named = [row for row in rows if row[1] in ("sure", "possible")]
    others = [row for row in rows if row[1] == "not it"]
    header = [
        "effect",
        "",
        "probability",
        f"size, {escape(str(summary.get('units', '')))}",
        "× noise of a capture",
    ]
    classes = ["", "", "number", "number", "number"]
    if named:
        sure = sum(row[1] == "sure" for row in named)
        page.add(table(header, [_cells(row) for row in named], classes, sure))
    if others:
        count = counted(len(others), "effect")
        less = "less" if len(others) == 1 else "each less"
        what = f"{capital(not_it(summary))}: {count}" + (f", {less} than 10 % probable" if named else "")
        body = table(header, [_cells(row) for row in others], classes)
        page.add(f"<details{'' if named else ' open'}><summary>{what}</summary>{body}</details>")
    if unseen := unseen_words(summary):
        page.add(f"<p>{escape(capital(unseen))}.</p>")


def values(page: Page, result: "Result") -> None:
    """What was fitted of each effect that was added, chamber by chamber or place by place."""
    shown = fitted(result)
    if not shown:
        return
    page.section("Values", "The fitted parameters of each added effect, with standard deviations.")
    chambers = {item.effect: item.chambers for item in result.signatures}
    unit = str(result.fields["commanded"].attrs.get("units", "")) if "commanded" in result.fields else ""
    over = most_moved_by(result.fields)
    for one in shown:
        page.add(_values(one, plain(result, one)))
        tables = place_tables(shown_of(one), chambers.get(one.effect, {}), unit, over, one.units)
        for kind, header, rows in tables:
            cells = [[escape(cell) for cell in row] for row in rows]
            names, classes = [escape(name) for name in header], ["", *["number"] * (len(header) - 1)]
            first = len(cells) if len(cells) <= FEW_ROWS else FIRST_ROWS
            page.add(table(names, cells[:first], classes))
            if rest := cells[first:]:
                more = counted(len(rest), f"more {kind}")
                page.add(f"<details><summary>{more}</summary>{table(names, rest, classes)}</details>")


def _cells(row: tuple[str, ...]) -> list[str]:
    name, call, *figures = row
    kind = call.replace(" ", "-")
    return [escape(name), f'<span class="call {kind}">{escape(call)}</span>', *map(escape, figures)]


def _values(one: Fitted, plain: str) -> str:
    form = f" ({one.form})" if one.form else ""
    said = f"{escape(plain)} " if plain else ""
    values = f'<span class="parameters">{escape(capital(values_words(shown_of(one), one.units)))}</span>'
    return f'<p class="values"><b>{escape(capital(word(one.effect)))}</b>{escape(form)}: {said}{values}</p>'


def ranking(page: Page, summary: Summary, units_of_values: Mapping[str, str]) -> None:
    """The likeliest effects, each by itself: the error with it alone, and its values.

    `units_of_values` are those of the observables.
    """
    rows = summary.get("ranking", [])
    if not rows:
        return
    chosen = set(added(summary))
    order = sorted(rows, key=lambda row: str(row.get("effect")) not in chosen)
    page.section(
        "Single-effect ranking",
        "The most probable effects, each fitted alone and scored on held-out captures. Explained: the share of the "
        "explainable error that it removes. A wrong effect can score well too: trust the probabilities above.",
    )

    def cells(row: Ranked) -> list[str]:
        drop = row.get("drop")
        share = "–" if drop is None else f"{100 * max(0.0, drop):.0f}"
        uncertainty = f" ± {max(1, round(100 * se))}" if (se := row.get("se")) is not None else ""
        form = f"{named}: " if (named := row.get("form")) else ""
        name = str(row.get("effect"))
        unit_in_names = known.unit_in_names if (known := library().get(name)) else ""
        alone = Fitted(name, "", row.get("parameters") or {}, unit_in_names=unit_in_names)
        words = form + values_words(shown_of(alone), units_of_values)
        return [
            escape(word(name)),
            number(row.get("heldout_error")),
            f"{bar(drop or 0.0, 90)} {share}{uncertainty} %",
            f'<span class="parameters">{escape(words)}</span>',
        ]

    units = escape(str(summary.get("units", "")))
    header = ["effect", f"held-out error, {units}", "explained", "values"]
    marked = sum(str(row.get("effect")) in chosen for row in order)
    page.add(table(header, [cells(row) for row in order], ["", "number", "bars", "values"], marked))
