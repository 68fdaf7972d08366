"""Spectra that several effects share are learnt from the laws of all of them, and change no other."""

import numpy as np

from labrig.bench._learn import Example, learn, learn_together
from labrig.effects._family import Space, pressure

ROWS = 60


def example(law: str, holds: dict[str, int], weights: tuple[float, float], seed: int) -> Example:
    """A law's change of one chamber, a line and a curve: laid out in a space for each spectrum, which holds the line
    alone or both (1 or 2).
    """
    x = np.random.default_rng(seed).uniform(0, 1, ROWS)
    values = np.stack([x, x**3], axis=1)
    change = values @ np.array(weights)
    features = (pressure("line", x[:, None]), pressure("curve", x[:, None] ** 3))
    spaces = tuple(Space(name, name, features[:count]) for name, count in holds.items())
    columns = tuple({"shared": values[:, :n], "pattern": np.zeros((ROWS, 0))} for n in holds.values())
    return Example(law, change / np.sqrt(np.mean(change**2)), spaces, columns)


def lines(effect: str) -> list[Example]:
    """Two laws of an effect that has a space of its own, and one that it shares: lines with little else."""
    return [example(f"{effect} {k}", {effect: 2, "any": 2}, (1.0, 0.01 * k), k) for k in range(2)]


def curves(effect: str) -> list[Example]:
    """Two laws that have next to no line."""
    return [example(f"{effect} {k}", {effect: 2, "any": 2}, (0.01 * k, 1.0), 7 + k) for k in range(2)]


def variances(spectrum: dict) -> np.ndarray:
    """Of the line and of the curve, as shares of both."""
    at = [spectrum["shared"]["features"].index(name) for name in ("line", "curve")]
    power = np.diag(spectrum["shared"]["covariance"])[at]
    return power / power.sum()


def test_what_is_shared_is_learnt_from_all_and_the_rest_from_its_own() -> None:
    """Lines of one effect and curves of another: each spectrum has its own, and that of both has both."""
    spectra = learn_together({"one": lines("one"), "two": curves("two")})
    assert set(spectra) == {"one", "two", "any"}
    assert variances(spectra["one"])[0] > 0.9
    assert variances(spectra["two"])[1] > 0.9
    assert variances(spectra["any"]).min() > 0.25


def test_what_is_shared_takes_no_law_from_what_an_effect_has_for_itself() -> None:
    """Also of laws that it holds better, an effect's own spectrum is learnt, as if it shared none."""
    bent = [example(f"one {k}", {"one": 1, "any": 2}, (1.0, 1.0), k) for k in range(2)]
    alone = learn([example(f"one {k}", {"one": 1}, (1.0, 1.0), k) for k in range(2)])
    assert learn_together({"one": bent, "two": curves("two")})["one"] == alone["one"]


def test_a_space_that_one_effect_has_is_nobody_elses() -> None:
    """Where only one effect has a space, it competes with the effect's others for each law."""
    spectra = learn_together({"one": lines("one")})
    assert spectra == learn(lines("one"))
