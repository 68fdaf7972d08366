"""train_forward and train_sim2real: models that are learnt, from simulations and from what a rig showed."""

from numbers import Integral, Real
from typing import TYPE_CHECKING, Any

from labrig._errors import LabrigError
from labrig._paths import path_of, paths_of
from labrig._seed import whole_seed
from labrig.api._inputs import AnyPath, runs_of

if TYPE_CHECKING:
    from labrig.surrogate import ForwardModel, Trained, TrainedWarp


def train_forward(
    simulations: AnyPath, *, method: str = "gaussian", share: float = 0.7, seed: int = 0, slopes: bool = True
) -> "Trained":
    """Learn a forward model from simulations: pressures to the surface.

    Args:
        simulations: a folder that `labrig simulate` made.
        method: gaussian (a Gaussian process), network (an ensemble of networks) or paper (the source paper's network).
        share: the share that is learnt from; errors are measured on the others.
        seed: of the split and of a network's training.
        slopes: use the simulations' derivatives, where they have them.

    Returns:
        the `model`, its `errors` in mm on what was left out, and how long it took; `labrig.surrogate.save_model(
        trained.model, "forward.pt")` writes it.

    Raises:
        LabrigError: the folder holds no simulations, or too few; or there is no such method.

    Example:
        >>> trained = labrig.train_forward("simulations")
        >>> trained.errors["shapes"]  # so many were left out; trained.errors["mean_mm"] is how far off it is there
        12.0
        >>> trained.model.points([10, 20, 30, 40], [[0.5, 0.5]]).shape  # of one set of pressures, at one (u, v)
        (1, 1, 3)
    """
    from typing import get_args

    from labrig import surrogate
    from labrig.physics import open_simulations
    from labrig.surrogate._train_forward import Method

    if method not in get_args(Method):
        raise LabrigError(f"method {method!r}: choose one of {', '.join(get_args(Method))}")
    if isinstance(share, bool) or not isinstance(share, Real) or not 0.0 < share < 1.0:
        raise LabrigError(f"share {share!r}: a number between 0 and 1, such as 0.7")
    seed = whole_seed(seed)
    folder = path_of(simulations, "a folder of simulations", "the path of a folder that labrig simulate made")
    data = surrogate.training_set(open_simulations(folder), folder)
    return surrogate.train_forward(data if slopes else data.without_slopes(), method, share, seed)  # type: ignore[arg-type]


def train_sim2real(
    run: Any,
    model: "AnyPath | ForwardModel | Trained",
    *,
    method: str = "ours",
    frames: int | None = None,
    seed: int = 0,
) -> "TrainedWarp":
    """Learn how a rig differs from its forward model, from a run with markers or scans.

    Args:
        run: a run folder's path, or several; what `labrig.open_run` gives will do where no scans are needed.
        model: a forward model's file, the model, or what `train_forward` has just given.
        method: ours (markers), scans, both, or the source paper's function and marker.
        frames: use so many frames only, the first ones.
        seed: of a network's training.

    Returns:
        the `model`, and distances in mm at what was left out of it in turn: `simulated_mm` before, `fixed_mm` after;
        both are empty where nothing can be left out, with a single set-point or marker. From scans alone they are
        across the surface. `notes`: what the run does not tell, such as how the rig is turned about a line of markers.

    Raises:
        LabrigError: a run has nothing of what the method needs, the model is no forward model, or `frames` is no count.

    Example:
        >>> trained = labrig.train_sim2real("runs/first", "forward.pt")
        >>> print(trained.fixed_mm.mean() < trained.simulated_mm.mean())
        True
    """
    from labrig import surrogate

    if method not in surrogate.METHODS:
        raise LabrigError(f"method {method!r}: choose one of {', '.join(surrogate.METHODS)}")
    seed = whole_seed(seed)
    if frames is not None and (isinstance(frames, bool) or not isinstance(frames, Integral) or frames < 1):
        raise LabrigError(f"frames {frames!r}: how many are used is a whole number, 1 or more")
    if isinstance(model, surrogate.ForwardModel | surrogate.Trained):
        forward = model.model if isinstance(model, surrogate.Trained) else model
    else:
        forward = surrogate.load_forward(path_of(model, "a forward model", "its file, or the model"))
    captured = None
    if method != "scans":
        each = [surrogate.frames_of(one, forward.chamber_names) for one in runs_of(run)]
        captured = surrogate.Frames.joined(each).take(slice(0, frames))
    shots = []
    if method in ("scans", "both"):
        folders = paths_of(run, f"method {method!r}: a run folder's path", "scans are files of the run")
        shots = [shot for folder in folders for shot in surrogate.shots_of(folder, forward.chamber_names)]
    return surrogate.train_warp(forward, captured, shots, method, seed)  # type: ignore[arg-type]
