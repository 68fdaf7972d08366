"""Markers that have other markers' names: in some rows each is where another is expected."""

import warnings
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from labrig.arrays import Floats, Ints
from labrig.diagnosis._listed import in_captures
from labrig.effects import Context, whole_markers

_NEARER = 3.0
"""How many times nearer a marker is to where another is expected than to its own place, where they are exchanged; and
how much farther apart these places are than the two usually are from theirs."""
_CLOSE = 0.25
"""Rows in which no marker is off by so much of the way to the nearest other are not looked at; numerical."""
_OTHERS = 4
"""Markers by which it is told what a marker between them is off: one of them may itself be exchanged."""
_NAMED = 4


def without_swapped(context: Context) -> tuple[Context, str]:
    """The campaign without the rows of markers that were exchanged there; the rows' warnings name them.

    And a line where a marker has another's name in most of the rows that see it: no mistake of single rows, so nothing
    can be said of an effect before the names are right.
    """
    rows = context.rows
    place = whole_markers(rows)
    if len(place) < 2:
        return context, ""
    markers = rows.marker[place[:, 0]]
    measured, expected = rows.values[:, place], context.base[:, place]
    gone, mutual = _exchanged(measured, expected)
    left = np.where(gone[:, :, None], np.nan, measured)
    more, more_mutual = _exchanged(left, expected + _as_others(left - expected, expected))
    gone, mutual = gone | more, mutual and more_mutual
    if not gone.any():
        return context, ""
    often = gone.sum(axis=0) > 0.5 * np.isfinite(measured).all(axis=2).sum(axis=0)
    values = rows.values.copy()
    for m, own in enumerate(place):
        values[np.ix_(gone[:, m], own)] = np.nan
    who = [rows.markers[markers[m]] for m in np.flatnonzero(gone.any(axis=0))]
    said = f"{_have_names(who, mutual)} in {in_captures(np.unique(rows.capture[gone.any(axis=1)]))}"
    line = f"{said}: left out there; label them again"
    always = f"{said}: let the mapping and the model name them alike" if often.any() else ""
    return replace(context, rows=replace(rows, values=values, warnings=(*rows.warnings, line))), always


def _have_names(who: Sequence[str], mutual: bool) -> str:
    """Who has whose names, in words."""
    names = [*who[:_NAMED], *(["others"] if len(who) > _NAMED else [])]
    whose = "each other's names" if mutual else "the names of others" if len(who) > 1 else "another's name"
    *first, last = names
    return f"{', '.join(first)} and {last} have {whose}" if first else f"{last} has {whose}"


def _as_others(off: Floats, expected: Floats) -> Floats:
    """What each marker is off (F, M, 3) by its neighbours: as most of those nearest to it are in the same row, and as
    it usually differs from them; none where none is seen.
    """
    middle = expected.mean(axis=0)
    nearest = np.linalg.norm(middle[:, None] - middle, axis=2).argsort(axis=1, kind="stable")[
        :, 1 : _OTHERS + 1
    ]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of rows that see none of them
        others = np.nanmedian(off[:, nearest], axis=2)
        return np.nan_to_num(others + np.nanmedian(off - others, axis=0))


def _exchanged(measured: Floats, expected: Floats) -> tuple[NDArray[np.bool_], bool]:
    """Which of the markers (F, M) are, in a row, where another is expected that is somewhere else itself, or is not
    seen; and whether all of them have each other's places.
    """
    off = np.linalg.norm(measured - expected, axis=2)
    seen = np.isfinite(off)
    to, away = _nearest(measured, expected, off)
    usual = np.full(off.shape[1], np.inf)
    known = seen.any(axis=0)
    usual[known] = np.nanmedian(away[:, known], axis=0)
    there = np.take_along_axis(expected, to[:, :, None], axis=1)
    apart = np.linalg.norm(expected - there, axis=2)
    moved = (to != np.arange(len(usual))) & (_NEARER * away < off)
    moved &= apart > _NEARER * np.maximum(usual, np.where(known, usual, 0.0)[to])
    while True:  # whoever is in another's place finds it left
        left = moved & np.take_along_axis(~seen | moved, to, axis=1)
        if (left == moved).all():
            break
        moved = left
    return moved, bool(np.take_along_axis(moved, to, axis=1)[moved].all())


def _nearest(measured: Floats, expected: Floats, off: Floats) -> tuple[Ints, Floats]:
    """The marker (F, M) in whose place each that is seen is, so that all are as near as can be, and how far from it."""
    seen = np.isfinite(off)
    to, away = np.tile(np.arange(off.shape[1]), (len(off), 1)), off.copy()
    middle = expected.mean(axis=0)
    between = np.linalg.norm(middle[:, None] - middle, axis=2) + np.diag(np.full(len(middle), np.inf))
    for f in np.flatnonzero((np.where(seen, off, 0.0) > _CLOSE * between.min(axis=0)).any(axis=1)):
        here = np.flatnonzero(seen[f])
        each = np.linalg.norm(measured[f][here][:, None] - expected[f], axis=2)
        _, found = linear_sum_assignment(each**2)
        to[f, here], away[f, here] = found, each[np.arange(len(here)), found]
    return to, away
