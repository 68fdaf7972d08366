"""Learning the prior spectra: how large which member of a family is, from laws of the development half.

Each law's change of the observables, without noise, is written in the features of its effect's family; the covariance
of the coefficients over laws, rigs and campaigns is the prior (empirical Bayes by expectation-maximisation: Dempster,
Laird, Rubin, J. R. Stat. Soc. B 39 (1977) 1). Every law counts alike. Each member's own size is taken out.
"""

import json
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from labrig._durable import put_at
from labrig.arrays import Floats, Ints
from labrig.bench._draw import draw
from labrig.bench._files import write_model
from labrig.bench.records import WholeTruth
from labrig.diagnosis._spectra import BLOCKS, Prior, factor, features_of, prior_of, unlearnt
from labrig.effects import Context, Effect, Space, library, motion_scale, rows_of
from labrig.model import Model

MISFIT = 0.05
"""By this share, root mean square, a law may be off its family: what is smaller isn't written into the spectrum."""
ROUNDS = 6
COUNTS_FOR = 400
"""As many independent numbers is a change worth: neighbours say the same."""
FORGET = 0.1
"""Share of the covariance that stays what it was before anything was learnt: other laws than those seen exist."""
_ROWS = 240

Columns: TypeAlias = Mapping[str, Floats | NDArray[np.float32]]


@dataclass(frozen=True)
class Example:
    """One law's change (n,), of unit size, and the columns (n, q) of each space that might hold it, by block."""

    law: str
    change: Floats
    spaces: tuple[Space, ...]
    columns: tuple[Columns, ...]


def example_of(context: Context, effect: Effect, change: Floats, law: str) -> Example | None:
    """Lay out what a law changes (F, K) in its effect's family; None where it changes hardly anything."""
    keep = np.unique(np.linspace(0, len(change) - 1, min(_ROWS, len(change))).astype(int))
    scale = motion_scale(context)
    y = np.nan_to_num(change)[keep] / scale
    size = float(np.sqrt((y**2).mean()))
    spaces = tuple(s for s in effect.family(context) if s.features and learnable(s))
    if size <= 0 or not spaces:
        return None
    J = (context.jacobian * context.span)[keep] / scale[None, :, None]
    # single precision, so that a thousand examples fit into memory: a spectrum has four digits
    columns = tuple(
        {block: values.astype(np.float32) for block, values in columns_of(s, J, keep, scale).items()}
        for s in spaces
    )
    return Example(law, (y / size).ravel(), spaces, columns)


def learnable(space: Space) -> bool:
    """Whether a spectrum can be learnt: its features are of the pressures above all, and mean the same on every rig."""
    kinds = {f.kind for f in space.features}
    return "pressure" in kinds and "pattern" not in kinds and space.apart is None


def columns_of(space: Space, J: Floats, keep: Ints, scale: Floats) -> dict[str, Floats]:
    """Columns of a space by block: shared (n, a), own (n, C, a), pattern features (F, a)."""
    n = J.shape[0] * J.shape[1]
    pressures = [f.values[keep] for f in space.features if f.kind == "pressure"]
    fields = [(f.values[keep] / scale).ravel() for f in space.features if f.kind == "field"]
    patterns = [f.values[keep] for f in space.features if f.kind == "pattern"]
    shared = [np.einsum("nkc,nc->nk", J, p).ravel() for p in pressures] + fields
    out = {"shared": np.stack(shared, axis=1) if shared else np.zeros((n, 0))}
    if pressures and J.shape[2] > 1:
        out["own"] = np.stack([(J * p[:, None, :]).reshape(n, -1) for p in pressures], axis=2)
    out["pattern"] = np.stack(patterns, axis=1) if patterns else np.zeros((len(keep), 0))
    return out


def learn(examples: Sequence[Example], forget: float = FORGET) -> dict[str, dict]:
    """The spectra of one effect's spaces, from examples of its laws; JSON-like, as `spectra.json` keeps them."""
    spectra: dict[str, dict] = {}
    for _ in range(ROUNDS):
        found: dict[str, list[tuple[str, Space, dict[str, Floats]]]] = {}
        for example in examples:
            i, moments = _best(example, spectra)
            space = example.spaces[i]
            found.setdefault(space.spectrum, []).append((example.law, space, moments))
        spectra = {name: _average(members, forget) for name, members in found.items()}
    return spectra


def _best(example: Example, spectra: dict) -> tuple[int, dict[str, Floats]]:
    """The space that holds an example best, and the second moments of its coefficients there."""
    best, out = -np.inf, (0, {})
    for i, (space, columns) in enumerate(zip(example.spaces, example.columns, strict=True)):
        value, moments = _fit(example.change, columns, prior_of(space, spectra))
        if value > best:
            best, out = value, (i, moments)
    return out


def _fit(y: Floats, columns: Columns, prior: Prior) -> tuple[float, dict[str, Floats]]:
    """Log evidence of a change of unit size under a prior of unit size, and the second moments of its coefficients by
    block.
    """
    parts = []
    shared = factor(prior.shared)
    if columns["shared"].shape[1]:
        parts.append(columns["shared"] @ shared)
    own = columns.get("own")
    L = factor(prior.own)
    if own is not None and L.size:
        n, C, _ = own.shape
        parts.append((own @ L).reshape(n, -1))
    P = columns["pattern"]
    M = factor(prior.pattern)
    if P.shape[1]:
        K = len(y) // len(P)
        Q = P @ M
        wide = np.zeros((len(P), K, Q.shape[1], K))
        wide[:, np.arange(K), :, np.arange(K)] = Q[None]
        parts.append(wide.reshape(len(y), -1))
    X = np.concatenate(parts, axis=1)
    total = float((X**2).sum() / len(y))
    if total <= 0:
        return -np.inf, {}
    X = X / np.sqrt(total)  # a member of unit size
    n = len(y)
    noise = MISFIT**2 * n / COUNTS_FOR
    A = X.T @ X / noise + np.eye(X.shape[1])
    c = np.linalg.inv(A)
    w = c @ (X.T @ y) / noise
    _, logdet = np.linalg.slogdet(A)
    value = 0.5 * float(w @ (X.T @ y)) / noise - 0.5 * logdet - 0.5 * float(y @ y) / noise
    second = np.outer(w, w) + c
    moments, start = {}, 0
    a = columns["shared"].shape[1] and shared.shape[1]
    if a:
        moments["shared"] = shared @ second[:a, :a] @ shared.T
        start = a
    if own is not None and L.size:
        C, a = own.shape[1], L.shape[1]
        total_own = sum(
            second[start + c * a : start + (c + 1) * a, start + c * a : start + (c + 1) * a] for c in range(C)
        )
        moments["own"] = L @ (total_own / C) @ L.T
        start += C * a
    if P.shape[1]:
        K, q = len(y) // len(P), M.shape[1]
        tensor = second[start:, start:].reshape(q, K, q, K)
        moments["pattern"] = M @ (np.einsum("akbk->ab", tensor) / K) @ M.T
    return value, moments


def _average(members: Sequence[tuple[str, Space, dict[str, Floats]]], forget: float) -> dict:
    """Mean covariance over laws, each over its own examples, with a share of what was believed before."""
    out = {}
    laws = sorted({law for law, _, _ in members})
    for block in BLOCKS:
        names = list(dict.fromkeys(n for _, space, _ in members for n in features_of(space, block)))
        if not names:
            continue
        at = {n: i for i, n in enumerate(names)}
        total, weight = np.zeros((len(names), len(names))), np.zeros((len(names), len(names)))
        for law, space, moments in members:
            share = 1.0 / sum(m[0] == law for m in members) / len(laws)
            own = [at[n] for n in features_of(space, block)]
            grid = np.ix_(own, own)
            before = unlearnt(space)
            belief = {b: getattr(before, b) for b in BLOCKS}
            trace = sum(np.trace(m) for m in moments.values()) / max(
                sum(np.trace(m) for m in belief.values()), 1e-300
            )
            if block in moments:
                total[grid] += share * ((1 - forget) * moments[block] + forget * trace * belief[block])
                weight[grid] += share
        covariance = total / np.where(weight > 0, weight, 1.0)
        power, U = np.linalg.eigh((covariance + covariance.T) / 2)
        covariance = (U * np.maximum(power, 0)) @ U.T
        out[block] = {
            "features": names,
            "covariance": [[float(f"{v:.4g}") for v in row] for row in covariance],
        }
    return out


def learn_all(seeds: Mapping[str, Iterable[int]]) -> dict[str, dict]:
    """The spectra of all effects, from single effects drawn with the seeds of each portion of the development half."""
    examples: dict[str, list[Example]] = {}
    for half, own in seeds.items():
        for seed in own:
            name, example = drawn_example(seed, half)
            if example is not None:
                examples.setdefault(name, []).append(example)
    return learn_together(examples)


def learn_together(examples: Mapping[str, Sequence[Example]]) -> dict[str, dict]:
    """The spectra of all effects, from examples of each one's laws.

    A spectrum that several effects have is learnt from all their laws, apart from what each has for itself: laws that
    are unlike those of its own may be like those of another.
    """
    owners = Counter(
        name for own in examples.values() for name in {s.spectrum for e in own for s in e.spaces}
    )
    shared = sorted(name for name, count in owners.items() if count > 1)
    spectra: dict[str, dict] = {}
    for name in sorted(examples):
        own = [only(example, lambda spectrum: spectrum not in shared) for example in examples[name]]
        spectra |= learn([example for example in own if example.spaces])
    for name in shared:
        all_laws = [only(example, name.__eq__) for own in examples.values() for example in own]
        spectra |= learn([example for example in all_laws if example.spaces])
    return spectra


def only(example: Example, wanted: Callable[[str], bool]) -> Example:
    """An example laid out in those of its spaces alone whose spectrum is wanted."""
    pairs = [p for p in zip(example.spaces, example.columns, strict=True) if wanted(p[0].spectrum)]
    return replace(example, spaces=tuple(s for s, _ in pairs), columns=tuple(c for _, c in pairs))


def drawn_change(seed: int, half: str) -> tuple[WholeTruth, Context, Floats]:
    """The truth of a campaign of a portion with one effect, its context, and what the law changes (F, K)."""
    campaign = draw("single", seed, half)
    change = campaign.parts[campaign.truth["effects"][0]]
    dataset = campaign.dataset.copy(deep=True)
    held = np.isfinite(dataset["hold_s"].values)
    seen = "position_mm" if "position_mm" in dataset else "observed"
    values = np.full(dataset[seen].shape, np.nan)
    values[held] = change.reshape(len(change), *values.shape[2:])
    with TemporaryDirectory(prefix="labrig-learn-") as folder:
        model = Model.load(write_model(campaign, Path(folder)))
        context = model.context(rows_of(campaign.dataset))
    dataset[seen].values[...] = values
    return campaign.truth, context, rows_of(dataset).values


def drawn_example(seed: int, half: str) -> tuple[str, Example | None]:
    """The effect of a campaign that is drawn from a portion, and its law's change laid out in the family."""
    truth, context, change = drawn_change(seed, half)
    name = truth["effects"][0]
    return name, example_of(context, library()[name], change, truth["laws"][0])


def write_spectra(spectra: dict[str, dict], path: Path, how: str) -> None:
    """Write spectra as `spectra.json`, in one piece or not at all."""
    lines = [f" {json.dumps(name)}: {json.dumps(value)}" for name, value in sorted(spectra.items())]
    text = '{"how": ' + json.dumps(how) + ',\n"spectra": {\n' + ",\n".join(lines) + "\n}}\n"
    partial = path.with_name(path.name + ".part")
    partial.write_text(text, encoding="utf-8", newline="\n")
    put_at(partial, path)
