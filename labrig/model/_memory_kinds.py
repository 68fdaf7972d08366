"""The kinds of bases with memory: a function of a record, a step with a state, a differential equation, an FMU."""

import inspect
import warnings
from pathlib import Path
from typing import Literal

import numpy as np

from labrig._errors import LabrigError
from labrig._extras import missing
from labrig.arrays import Floats
from labrig.effects import Rows
from labrig.model._file import FmuBase, OdeBase, PythonBase
from labrig.model._memory import MemoryModel
from labrig.model._python import function_of, load_function, place_of

_FEW_HOLDS = 500
"""So many different inputs in a record are integrated one by one; more are a stream, followed by small steps."""


def memory_of(spec: PythonBase, folder: Path) -> Literal["none", "record", "step"]:
    """What a function remembers: as the model says, or by how many parameters it has to be given (1, 2 or 3)."""
    if spec.memory is not None:
        return spec.memory
    function = function_of(spec, folder)
    try:
        parameters = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):
        return "none"
    needed = [
        p
        for p in parameters
        if p.default is p.empty and p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)
    ]
    return {2: "record", 3: "step"}.get(len(needed), "none")  # type: ignore[return-value]


class RecordModel(MemoryModel):
    """``predict(u, t)`` over a whole record."""

    kind = "python"
    _given = (
        " on a whole record (u, t), as it has two parameters; a function of set-points alone takes all in one"
    )

    def __init__(self, spec: PythonBase, folder: Path, rows: Rows) -> None:
        self._function = function_of(spec, folder)
        super().__init__(place_of(spec, folder), rows, spec.max_step_s)

    def _simulate(self, u: Floats, t: Floats) -> object:
        return self._function(u, t)


class StepModel(MemoryModel):
    """``step(state, u, dt_s) -> (state, y)``: the output at a sample, and the state at the next one, `dt_s` later."""

    kind = "python"

    def __init__(self, spec: PythonBase, folder: Path, rows: Rows) -> None:
        where = place_of(spec, folder)
        if spec.state is None:
            raise LabrigError(f"{where}: a step needs the state that it begins with: base: state: [0.0]")
        self._function = function_of(spec, folder)
        self._state = np.array(spec.state, dtype=float)
        super().__init__(where, rows, spec.max_step_s)

    def _simulate(self, u: Floats, t: Floats) -> object:
        state = self._state.copy()
        steps = np.diff(t, append=t[-1] + self._dt) if len(t) > 1 else np.array([self._dt])
        out = []
        for now, dt_s in zip(u, steps.tolist(), strict=True):
            state, y = self._function(state, now, dt_s)
            out.append(np.array(y, dtype=float).reshape(-1))
        return np.array(out)


class OdeModel(MemoryModel):
    """``dx/dt = rate(t, x, u)``, ``y = output(x, u)``, integrated by scipy's LSODA."""

    kind = "ode"

    def __init__(self, spec: OdeBase, folder: Path, rows: Rows) -> None:
        self._rate = load_function(folder / spec.file, spec.rate)
        self._output = load_function(folder / spec.file, spec.output)
        self._spec = spec
        super().__init__(f"{folder / spec.file}:{spec.rate}", rows, None)

    def _simulate(self, u: Floats, t: Floats) -> object:
        states = self._states(u, t)
        return np.array(
            [np.array(self._output(x, v), float).reshape(-1) for x, v in zip(states, u, strict=True)]
        )

    def _states(self, u: Floats, t: Floats) -> Floats:
        out = np.zeros((len(t), len(self._spec.state)))
        out[0] = self._spec.state
        changes = np.flatnonzero((np.diff(u, axis=0) != 0).any(axis=1)) + 1
        if self._spec.input == "held" and len(changes) <= _FEW_HOLDS:
            for begin, end in zip([0, *changes.tolist()], [*changes.tolist(), len(t) - 1], strict=True):
                if end > begin:
                    out[begin : end + 1] = self._integrate(
                        out[begin], t[begin : end + 1], u[begin : begin + 1]
                    )
            return out
        if len(t) > 1:
            out[:] = self._integrate(out[0], t, u)
        return out

    def _finite(self, now: float, x: Floats, u: Floats) -> Floats:
        """The rate; what is not finite would have LSODA take ever smaller steps."""
        rate = np.asarray(self._rate(now, x, u), dtype=float)
        if not np.isfinite(rate).all():
            raise LabrigError(
                f"{self._where}: can't be integrated beyond {now:.6g} s: the rate is not finite"
            )
        return rate

    def _integrate(self, state: Floats, t: Floats, u: Floats) -> Floats:
        """From `state` along `t`, with one input for all of it, or one from each time on."""
        from scipy.integrate import solve_ivp

        if len(u) == 1:

            def rate(now: float, x: Floats) -> object:
                return self._finite(now, x, u[0])

            longest = np.inf
        else:
            linear = self._spec.input == "linear"
            slopes = np.diff(u, axis=0) / np.diff(t)[:, None]
            longest = float(np.diff(t).max())

            def rate(now: float, x: Floats) -> object:
                i = min(max(int(np.searchsorted(t, now, side="right")) - 1, 0), len(t) - 2)
                return self._finite(now, x, u[i] + slopes[i] * (now - t[i]) if linear else u[i])

        scale = np.maximum(np.abs(self._spec.state), 1.0)
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")  # what goes wrong is said below, by its time
            solved = solve_ivp(
                rate,
                (float(t[0]), float(t[-1])),
                state,
                method="LSODA",
                t_eval=t,
                rtol=self._spec.rtol,
                atol=self._spec.rtol * 1e-2 * scale,
                max_step=longest,
            )
        if not solved.success or solved.y.shape[1] != len(t):
            raise LabrigError(
                f"{self._where}: can't be integrated beyond {solved.t[-1] if len(solved.t) else t[0]:.6g} s "
                f"({solved.message})"
            )
        return solved.y.T


class FmuModel(MemoryModel):
    """A model of another tool, run by FMPy as a co-simulation or model exchange, whichever it offers."""

    kind = "fmu"

    def __init__(self, spec: FmuBase, folder: Path, rows: Rows) -> None:
        try:
            import fmpy
        except ImportError:
            raise missing("an FMU as a base", "fmu") from None
        path = folder / spec.file
        if not path.is_file():
            raise LabrigError(f"{path}: the model's FMU does not exist")
        try:
            variables = {v.name for v in fmpy.read_model_description(str(path)).modelVariables}
        except Exception as error:
            raise LabrigError(f"{path}: can't be read as an FMU ({type(error).__name__}: {error})") from error
        for what, names, given in (
            ("inputs", rows.chambers, spec.inputs),
            ("outputs", rows.observables, spec.outputs),
        ):
            for name in names:
                if name not in given:
                    raise LabrigError(f"{path}: base: {what}: says nothing of {name!r}, which the run has")
                if given[name] not in variables:
                    raise LabrigError(f"{path}: base: {what}: the FMU has no variable {given[name]!r}")
        self._path, self._spec = path, spec
        self._inputs = [spec.inputs[c] for c in rows.chambers]
        self._outputs = [spec.outputs[o] for o in rows.observables]
        super().__init__(str(path), rows, None)

    def _simulate(self, u: Floats, t: Floats) -> object:
        import fmpy

        signals = np.zeros(len(t), dtype=[("time", float), *((name, float) for name in self._inputs)])
        signals["time"] = t
        for c, name in enumerate(self._inputs):
            signals[name] = u[:, c]
        step = float(np.median(np.diff(t))) if len(t) > 1 else 1.0
        result = fmpy.simulate_fmu(
            str(self._path),
            start_time=float(t[0]),
            stop_time=float(t[-1]) + step,
            output_interval=step,
            start_values={**self._spec.parameters, **dict(zip(self._inputs, u[0].tolist(), strict=True))},
            input=signals,
            output=self._outputs,
        )
        return np.stack([np.interp(t, result["time"], result[name]) for name in self._outputs], axis=1)
