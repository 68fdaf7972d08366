"""Training of small networks with torch; what comes out are plain arrays."""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from labrig._extras import missing
from labrig.arrays import Floats
from labrig.surrogate._network import Network


@dataclass(frozen=True)
class Recipe:
    """A network and how it is trained: `hidden` widths, `activation`, and Adam at `rate` for `epochs`.

    `one_cycle`: the rate rises and falls once; else it stays. `slope_weight` counts errors of slopes beside those of
    values, where slopes are known.
    """

    hidden: tuple[int, ...]
    activation: str = "relu"
    batch_norm: bool = False
    epochs: int = 150
    batch: int = 32
    rate: float = 1e-3
    one_cycle: bool = False
    slope_weight: float = 0.3


def import_torch() -> Any:
    """torch, for training; raises `LabrigError` where it is not installed."""
    try:
        import torch
    except ImportError as error:
        raise missing("training a network", "learn") from error
    return torch


@contextmanager
def one_thread(seed: int) -> Iterator[Any]:
    """torch with one thread (small matrices: more would wait for each other) and its own seeded chance."""
    torch = import_torch()
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(seed)
            yield torch
    finally:
        torch.set_num_threads(threads)


def train_network(
    x: Floats, targets: Floats, recipe: Recipe, seed: int, slopes: Floats | None = None
) -> Network:
    """Train a network from inputs (n, C) to targets (n, D), with slopes (n, D, C) if there are any."""
    with one_thread(seed) as torch:
        net = sequential(torch, x.shape[1], targets.shape[1], recipe)
        data = [torch.tensor(np.asarray(v), dtype=torch.float32) for v in (x, targets)]
        by_x = None if slopes is None else torch.tensor(slopes.transpose(0, 2, 1), dtype=torch.float32)
        count, batches = len(x), math.ceil(len(x) / recipe.batch)
        optimiser = torch.optim.Adam(net.parameters(), lr=recipe.rate)
        schedule = None
        if recipe.one_cycle:
            schedule = torch.optim.lr_scheduler.OneCycleLR(
                optimiser, recipe.rate, recipe.epochs * batches, pct_start=0.1
            )
        net.train()
        for _ in range(recipe.epochs):
            order = torch.randperm(count)
            for start in range(0, count, recipe.batch):
                chosen = order[start : start + recipe.batch]
                if recipe.batch_norm and len(chosen) < 2:
                    continue
                if by_x is None:
                    loss = ((net(data[0][chosen]) - data[1][chosen]) ** 2).mean()
                else:
                    value, change = _with_slopes(torch, net, data[0][chosen], recipe.activation)
                    loss = ((value - data[1][chosen]) ** 2).mean()
                    loss = loss + recipe.slope_weight * ((change - by_x[chosen]) ** 2).mean()
                optimiser.zero_grad(set_to_none=True)
                loss.backward()
                optimiser.step()
                if schedule is not None:
                    schedule.step()
        net.eval()
        return plain(net, recipe.activation)


def sequential(torch: Any, inputs: int, outputs: int, recipe: Recipe) -> Any:
    """The network of a recipe, its weights drawn anew."""
    layers, width = [], inputs
    for hidden in recipe.hidden:
        layers.append(torch.nn.Linear(width, hidden))
        if recipe.batch_norm:
            layers.append(torch.nn.BatchNorm1d(hidden))
        layers.append(torch.nn.ReLU() if recipe.activation == "relu" else torch.nn.GELU())
        width = hidden
    layers.append(torch.nn.Linear(width, outputs))
    return torch.nn.Sequential(*layers)


def _with_slopes(torch: Any, net: Any, x: Any, activation: str) -> tuple[Any, Any]:
    """Values (n, D) and slopes (n, C, D): the derivative is carried forward beside the value."""
    change = torch.eye(x.shape[1]).expand(len(x), -1, -1)
    for layer in net:
        if isinstance(layer, torch.nn.Linear):
            x, change = layer(x), change @ layer.weight.T
            continue
        if activation == "relu":
            slope = (x > 0).to(x.dtype)
        else:
            slope = 0.5 * (1 + torch.erf(x * math.sqrt(0.5)))
            slope = slope + x * torch.exp(-0.5 * x * x) / math.sqrt(2 * math.pi)
        x, change = layer(x), change * slope[:, None, :]
    return x, change


def plain(net: Any, activation: str) -> Network:
    """The arrays of a trained network of linear layers; batch normalisation goes into the layer before it."""
    layers: list[tuple[Floats, Floats]] = []
    for layer in net:
        if hasattr(layer, "running_mean"):
            stretch = layer.weight / (layer.running_var + layer.eps).sqrt()
            weight, bias = layers[-1]
            factor = stretch.detach().numpy().astype(float)
            shift = (layer.bias - layer.running_mean * stretch).detach().numpy().astype(float)
            layers[-1] = (weight * factor[:, None], bias * factor + shift)
        elif hasattr(layer, "weight"):
            arrays = (layer.weight.detach().numpy().astype(float), layer.bias.detach().numpy().astype(float))
            layers.append(arrays)
    return Network(tuple(layers), activation)
