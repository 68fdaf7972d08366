"""Learned models to facts and arrays, and back, checked on the way."""

from pathlib import Path
from typing import Any, NoReturn, NotRequired, TypedDict

import numpy as np

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.surface import Spline
from labrig.surrogate._corrected import CorrectedHead
from labrig.surrogate._field_settings import Settings
from labrig.surrogate._file import Arrays
from labrig.surrogate._forward import ForwardModel
from labrig.surrogate._gaussian import GaussianHead
from labrig.surrogate._kernel import Kernel
from labrig.surrogate._network import Network, NetworkHead
from labrig.surrogate._warp_heads import FieldHead, FunctionHead, MarkerHead
from labrig.surrogate._warped import Doubt, WarpedModel


class NetworkFacts(TypedDict):
    """Of a network: how many layers, and what is between them."""

    layers: int
    activation: str
    linear_end: bool


class ForwardFacts(TypedDict):
    """Of a forward model; `head` is as its kind has it, `provenance` as the learner wrote it."""

    chamber_names: list[str]
    marker_names: list[str]
    control_points: list[int]
    degree: int
    factor: float
    head: dict[str, Any]
    provenance: dict[str, Any]


class WarpHeadFacts(TypedDict):
    """Of the head of a warped model."""

    kind: str
    network: NotRequired[NetworkFacts]
    slack: NotRequired[float]


class DoubtFacts(TypedDict):
    """Of what tells how well a field is known; `along_normals` where scans alone showed it."""

    rough: float
    along_normals: NotRequired[bool]


class WarpedFacts(TypedDict):
    """Of a warped model; `doubt` is that of a field, since format 2."""

    forward: ForwardFacts
    head: WarpHeadFacts
    c_per_mm2: float
    noise_mm: float
    factor: float
    provenance: dict[str, Any]
    doubt: NotRequired[DoubtFacts]


class Unpacking:
    """Arrays and facts of a file; whatever is missing or has another shape is a one-line error."""

    def __init__(self, path: Path, facts: dict[str, Any], arrays: Arrays, prefix: str = "") -> None:
        self._path, self.facts, self._arrays, self._prefix = path, facts, arrays, prefix

    def inner(self, name: str) -> "Unpacking":
        """The part of the file under a name."""
        return Unpacking(self._path, self.fact(name, dict), self._arrays, f"{self._prefix}{name}.")

    def fact(self, name: str, kind: type) -> Any:
        """A fact of a kind."""
        value = self.facts.get(name)
        if kind is float and isinstance(value, int) and not isinstance(value, bool):
            value = float(value)
        if not isinstance(value, kind):
            self.fail(f"{self._prefix}{name} is missing or is no {kind.__name__}")
        return value

    def names(self, name: str) -> tuple[str, ...]:
        """A fact that is a list of texts."""
        value = self.fact(name, list)
        if not all(isinstance(item, str) for item in value):
            self.fail(f"{self._prefix}{name} is no list of names")
        return tuple(value)

    def array(self, name: str, *shape: int | None) -> Floats:
        """An array of finite numbers of a shape; None stands for any size."""
        array = self._arrays.get(self._prefix + name)
        if array is None or array.dtype.kind not in "fiu":
            self.fail(f"{self._prefix}{name} is missing or holds no numbers")
        wrong = array.ndim != len(shape) or any(
            want is not None and have != want for have, want in zip(array.shape, shape, strict=False)
        )
        if wrong or not np.isfinite(array).all():
            self.fail(f"{self._prefix}{name} has shape {array.shape}, or numbers that are not finite")
        return np.asarray(array, dtype=float)

    def fail(self, what: str) -> NoReturn:
        """Raise the error of a damaged file."""
        raise LabrigError(f"{self._path}: is damaged ({what})")


def pack_network(network: Network, arrays: Arrays, prefix: str) -> NetworkFacts:
    """Facts of a network; its arrays are put under the prefix."""
    for index, (weight, bias) in enumerate(network.layers):
        arrays[f"{prefix}weight{index}"], arrays[f"{prefix}bias{index}"] = weight, bias
    return {
        "layers": len(network.layers),
        "activation": network.activation,
        "linear_end": network.linear_end,
    }


def unpack_network(part: Unpacking, inputs: int, outputs: int | None) -> Network:
    """A network with this many inputs and outputs."""
    layers = []
    for index in range(part.fact("layers", int)):
        bias = part.array(f"bias{index}", None)
        layers.append((part.array(f"weight{index}", len(bias), inputs), bias))
        inputs = len(bias)
    if not layers or outputs not in (None, inputs):
        part.fail(f"a network has {inputs} outputs, not {outputs}")
    activation = part.fact("activation", str)
    if activation not in ("relu", "gelu"):
        part.fail(f"there is no activation {activation!r}")
    return Network(tuple(layers), activation, part.fact("linear_end", bool))


def pack_kernel(kernel: Kernel, arrays: Arrays, prefix: str) -> None:
    """Put a kernel's parameters under the prefix."""
    for name in ("length", "bend", "share"):
        arrays[f"{prefix}{name}"] = getattr(kernel, name)


def unpack_kernel(part: Unpacking, chambers: int) -> Kernel:
    """A kernel of this many chambers; its parameters are positive."""
    values = [part.array(name, chambers) for name in ("length", "bend", "share")]
    if any((value <= 0).any() for value in values):
        part.fail("a kernel's parameters must be positive")
    return Kernel(*values)


def pack_forward(model: ForwardModel, arrays: Arrays, prefix: str = "") -> ForwardFacts:
    """Facts of a forward model; its arrays are put under the prefix."""
    for name in ("low_kpa", "high_kpa", "mean_mm", "spread", "marker_uv"):
        arrays[prefix + name] = getattr(model, name)
    arrays[prefix + "modes_mm"] = model.modes_mm.astype(np.float32)
    return {
        "chamber_names": list(model.chamber_names),
        "marker_names": list(model.marker_names),
        "control_points": list(model.spline.count),
        "degree": model.spline.degree,
        "factor": model.factor,
        "head": _pack_head(model.head, arrays, f"{prefix}head."),
        "provenance": model.provenance,
    }


def _pack_head(head: Any, arrays: Arrays, prefix: str) -> dict[str, Any]:
    if isinstance(head, GaussianHead):
        pack_kernel(head.kernel, arrays, prefix)
        for name in ("points", "weights", "offset", "scale"):
            arrays[prefix + name] = getattr(head, name)
        return {"kind": "gaussian", "noise": head.noise}
    if isinstance(head, CorrectedHead):
        pack_kernel(head.kernel, arrays, prefix)
        for name in ("gain", "points", "constant", "weights"):
            arrays[prefix + name] = getattr(head, name)
        return {"kind": "corrected", "base": _pack_head(head.base, arrays, f"{prefix}base.")}
    facts: dict[str, Any] = {"kind": "network", "scale": head.scale, "members": len(head.members)}
    for index, member in enumerate(head.members):
        facts[f"member{index}"] = pack_network(member, arrays, f"{prefix}member{index}.")
    return facts


def unpack_forward(part: Unpacking) -> ForwardModel:
    """A forward model, every array of the size that the others ask for."""
    chambers, markers = part.names("chamber_names"), part.names("marker_names")
    count = part.fact("control_points", list)
    degree = part.fact("degree", int)
    if len(count) != 2 or not all(isinstance(n, int) and n > degree for n in count) or degree < 1:
        part.fail(f"a spline of {count} control points of degree {degree}")
    modes = part.array("modes_mm", None, *count, 3)
    low, high = part.array("low_kpa", len(chambers)), part.array("high_kpa", len(chambers))
    if not chambers or not (high > low).all():
        part.fail("its chambers have no range")
    return ForwardModel(
        chamber_names=chambers,
        low_kpa=low,
        high_kpa=high,
        spline=Spline((count[0], count[1]), degree),
        mean_mm=part.array("mean_mm", *count, 3),
        modes_mm=modes,
        head=_unpack_head(part.inner("head"), len(chambers), len(modes)),
        spread=part.array("spread", len(modes), None),
        factor=part.fact("factor", float),
        marker_names=markers,
        marker_uv=part.array("marker_uv", len(markers), 2),
        provenance=part.fact("provenance", dict),
    )


def _unpack_head(
    part: Unpacking, chambers: int, modes: int, deep: bool = False
) -> GaussianHead | NetworkHead | CorrectedHead:
    kind = part.fact("kind", str)
    if kind == "corrected" and not deep:
        base = _unpack_head(part.inner("base"), chambers, modes, deep=True)
        points, gain = part.array("points", None, chambers), part.array("gain", chambers)
        constant, weights = part.array("constant", modes), part.array("weights", len(points), modes)
        return CorrectedHead(base, gain, unpack_kernel(part, chambers), points, constant, weights)
    if kind == "gaussian":
        points = part.array("points", None, chambers)
        weights = part.array("weights", None, modes)
        if len(weights) not in (len(points), len(points) * (1 + chambers)):
            part.fail(f"{len(weights)} weights for {len(points)} points")
        offset, scale = part.array("offset", modes), part.array("scale", modes)
        noise = part.fact("noise", float)
        return GaussianHead(unpack_kernel(part, chambers), noise, points, weights, offset, scale)
    if kind != "network":
        part.fail(f"there is no head of kind {kind!r}")
    members = range(part.fact("members", int))
    if not members:
        part.fail("an ensemble without members")
    return NetworkHead(
        tuple(unpack_network(part.inner(f"member{index}"), chambers, modes) for index in members),
        part.fact("scale", float),
    )


def pack_warped(model: WarpedModel, arrays: Arrays) -> WarpedFacts:
    """Facts of a warped model; its arrays are put beside them."""
    for name in ("marker_uv", "field_mm", "confidence", "rotation", "translation_mm"):
        arrays[name] = getattr(model, name)
    head: WarpHeadFacts = {"kind": model.head.kind}
    if isinstance(model.head, FieldHead):
        pack_kernel(model.head.kernel, arrays, "head.")
        for name in ("points", "constant", "weights"):
            arrays[f"head.{name}"] = getattr(model.head, name)
    elif isinstance(model.head, FunctionHead):
        arrays["head.scale"] = model.head.scale
        head["network"] = pack_network(model.head.network, arrays, "head.network.")
    elif isinstance(model.head, MarkerHead):
        head["slack"] = model.head.slack
        head["network"] = pack_network(model.head.network, arrays, "head.network.")
    facts: WarpedFacts = {
        "forward": pack_forward(model.forward, arrays, "forward."),
        "head": head,
        "c_per_mm2": model.c,
        "noise_mm": model.noise_mm,
        "factor": model.factor,
        "provenance": model.provenance,
    }
    if model.doubt is not None:
        for name in ("settings", "precision", "gain_sd"):
            arrays[f"doubt.{name}"] = getattr(model.doubt, name)
        facts["doubt"] = {"rough": model.doubt.rough}
        if model.doubt.along is not None:
            arrays["doubt.along"] = model.doubt.along
            facts["doubt"]["along_normals"] = True
    return facts


def unpack_warped(part: Unpacking) -> WarpedModel:
    """A warped model, every array of the size that the others ask for."""
    forward = unpack_forward(part.inner("forward"))
    chambers, uv = len(forward.chamber_names), part.array("marker_uv", None, 2)
    return WarpedModel(
        forward=forward,
        marker_uv=uv,
        c=part.fact("c_per_mm2", float),
        head=_unpack_warp_head(part.inner("head"), len(uv), len(forward.modes_mm), chambers),
        noise_mm=part.fact("noise_mm", float),
        field_mm=part.array("field_mm", None, None),
        factor=part.fact("factor", float),
        confidence=part.array("confidence", None, None),
        rotation=part.array("rotation", 3, 3),
        translation_mm=part.array("translation_mm", 3),
        provenance=part.fact("provenance", dict),
        doubt=_unpack_doubt(part.inner("doubt"), forward, len(uv)) if "doubt" in part.facts else None,
    )


def _unpack_doubt(part: Unpacking, forward: ForwardModel, centers: int) -> Doubt:
    """What tells how well the field is known, for a forward model that it has corrected."""
    if not isinstance(forward.head, CorrectedHead):
        part.fail("a doubt of a field, and no field")
    return Doubt(
        part.array("settings", len(Settings.usual().values)),
        part.array("precision", centers),
        part.array("gain_sd", len(forward.chamber_names)),
        part.fact("rough", float),
        part.array("along", centers, 3) if "along_normals" in part.facts else None,
    )


def _unpack_warp_head(
    part: Unpacking, centers: int, modes: int, chambers: int
) -> FieldHead | FunctionHead | MarkerHead:
    kind = part.fact("kind", str)
    if kind == "function":
        network = unpack_network(part.inner("network"), modes, 3 * (centers + 4))
        return FunctionHead(network, part.array("scale", centers + 4))
    if kind == "marker":
        network = unpack_network(part.inner("network"), modes, 3 * centers)
        return MarkerHead(network, part.fact("slack", float))
    if kind != "field":
        part.fail(f"there is no head of kind {kind!r}")
    points = part.array("points", None, chambers)
    constant = part.array("constant", centers + 4, 3)
    return FieldHead(
        unpack_kernel(part, chambers), points, constant, part.array("weights", len(points), centers + 4, 3)
    )
