"""The source paper's networks for the sim-to-real correction: N_rbf, and its baseline N_mk."""

import numpy as np

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.surface import design
from labrig.surrogate._captures import Frames
from labrig.surrogate._field_settings import LEAST_EXTENT_MM
from labrig.surrogate._forward import ForwardModel
from labrig.surrogate._network import Network
from labrig.surrogate._torch_training import Recipe, one_thread, plain, sequential, train_network
from labrig.surrogate._warp_heads import FunctionHead, MarkerHead

PAPER_C = 3e-5
"""Width of the bells, mm^-2."""
PAPER_WARP = Recipe((24, 24), "relu", epochs=150, batch=32, rate=1e-3)
_FEWEST = 2
_FLAT = 1e-6
"""Markers whose third extent is less than this of their largest lie in one plane."""


def train_function(
    forward: ForwardModel, frames: Frames, seed: int, recipe: Recipe = PAPER_WARP
) -> FunctionHead:
    """N_rbf: a network from control points to the warp's coefficients, from every marker that was captured.

    The loss is the squared distance between warped virtual markers and captured ones; markers that are missing
    do not count, and the forward model stays as it is. Control points go in as deviations from their mean, in
    units of their spread; coefficients come out as what they are besides the identity's, A in mm per extent.
    """
    uv = forward.markers(frames.marker_names)
    virtual = forward.points(frames.pressure_kpa, uv)
    control = forward.control(frames.pressure_kpa).reshape(len(frames), -1)
    middle, spread = control.mean(axis=0), max(float(control.std(axis=0).mean()), 1e-9)
    rows = np.stack([design(q, q, PAPER_C) for q in virtual])
    scale = np.ones(rows.shape[2])
    scale[1:4] = 1.0 / max(float(np.linalg.norm(np.ptp(virtual.mean(axis=0), axis=0))), LEAST_EXTENT_MM)
    wanted = np.nan_to_num(frames.position_mm - virtual)
    with one_thread(seed) as torch:
        net = sequential(torch, control.shape[1], 3 * len(scale), recipe)
        x, d, y, m = (
            torch.tensor(np.asarray(v), dtype=torch.float32)
            for v in ((control - middle) / spread, rows * scale, wanted, frames.captured[..., None])
        )
        optimiser = torch.optim.Adam(net.parameters(), lr=recipe.rate)
        for _ in range(recipe.epochs):
            order = torch.randperm(len(x))
            for start in range(0, len(x), recipe.batch):
                chosen = order[start : start + recipe.batch]
                moved = d[chosen] @ net(x[chosen]).reshape(len(chosen), -1, 3)
                loss = (m[chosen] * (moved - y[chosen]) ** 2).sum() / m[chosen].sum().clamp(min=1)
                optimiser.zero_grad(set_to_none=True)
                loss.backward()
                optimiser.step()
        network = plain(net, recipe.activation)
    return FunctionHead(_on_latent(network, forward, middle, spread), scale)


def train_marker(forward: ForwardModel, frames: Frames, seed: int, recipe: Recipe = PAPER_WARP) -> MarkerHead:
    """N_mk: a network from the virtual markers to the displacements of the real ones, from complete frames only.

    Raises `LabrigError` when there are fewer than two of them, and for markers through which no warp can be laid: fewer
    than four, or all in one plane in every frame.
    """
    whole = frames.take(frames.complete)
    if len(whole) < _FEWEST:
        raise LabrigError(
            f"sim2real: the method marker needs {_FEWEST} frames with every marker, the run has {len(whole)}; "
            "other methods use incomplete frames too"
        )
    uv = forward.markers(frames.marker_names)
    places = forward.points(whole.pressure_kpa, uv)
    if max(np.linalg.matrix_rank(q - q.mean(axis=0), rtol=_FLAT) for q in places) < 3:
        raise LabrigError(
            "sim2real: the method marker needs four markers that are not all in one plane, which the run's "
            f"{len(uv)} are not; other methods do with fewer"
        )
    virtual = places.reshape(len(whole), -1)
    middle, spread = virtual.mean(axis=0), max(float(virtual.std(axis=0).mean()), 1e-9)
    moved = whole.position_mm.reshape(len(whole), -1) - virtual
    network = train_network((virtual - middle) / spread, moved, recipe, seed)
    flat = forward.modes_mm.reshape(len(forward.modes_mm), -1, 3)
    basis = forward.basis(uv)
    modes = np.stack([(basis @ mode).ravel() for mode in flat])
    mean = (basis @ forward.mean_mm.reshape(-1, 3)).ravel()
    return MarkerHead(_folded(network, modes, mean - middle, spread))


def _on_latent(network: Network, forward: ForwardModel, middle: Floats, spread: float) -> Network:
    modes = forward.modes_mm.reshape(len(forward.modes_mm), -1)
    return _folded(network, modes, forward.mean_mm.ravel() - middle, spread)


def _folded(network: Network, modes: Floats, shift: Floats, spread: float) -> Network:
    """The same network with z for input, where its own input was (shift + z @ modes) / spread."""
    weight, bias = network.layers[0]
    first = (np.ascontiguousarray(weight @ modes.T) / spread, bias + weight @ shift / spread)
    return Network((first, *network.layers[1:]), network.activation, network.linear_end)
