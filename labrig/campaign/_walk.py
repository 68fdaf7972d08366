"""Runs a procedure's generator: every step is carried out by somebody else, every result goes back in."""

import traceback
from collections.abc import Callable
from pathlib import Path

from labrig._errors import LabrigError
from labrig._own_code import FAULTS
from labrig.campaign._advice import Adviser
from labrig.campaign._procedure import Procedure, RigInfo, Steps
from labrig.campaign._steps import Result, Step, StepError


class ProcedureError(LabrigError):
    """The procedure's own code failed; the message says where."""


class Walk:
    """A procedure under way. It is closed by its owner, after the chambers are vented."""

    def __init__(self, procedure: Procedure, info: RigInfo, adviser: Adviser | None = None) -> None:
        self._name = procedure.procedure_name()
        self.index = 0
        try:
            self._generator: Steps = procedure.steps(info)
        except LabrigError:
            raise
        except FAULTS as error:  # `steps` without a `yield` runs here
            raise self._failed(error) from error
        if not hasattr(self._generator, "send"):
            raise ProcedureError(f"procedure {self._name}: `steps` should `yield` its steps, not return them")
        if adviser is not None:
            self._generator = adviser.follow(self._generator, info)

    def run(self, carry_out: Callable[[int, Step], Result], thinking: Callable[[], None]) -> None:
        """Carry out every step; `thinking` is called before the procedure's own code runs."""
        result: Result = None
        first = True
        while True:
            thinking()
            step = self._next(result, first)
            if step is None:
                return
            first = False
            result = carry_out(self.index, step)
            self.index += 1

    def _next(self, result: Result, first: bool) -> Step | None:
        try:
            step = next(self._generator) if first else self._generator.send(result)
        except StopIteration:
            return None
        except StepError as error:
            said = LabrigError(f"procedure {self._name}, step {self.index}: {error}")
            raise said.with_traceback(error.__traceback__) from None
        except LabrigError:
            raise
        except FAULTS as error:
            raise self._failed(error) from error
        if not isinstance(step, Step):
            raise ProcedureError(
                f"procedure {self._name} yielded {step!r} at step {self.index}; it should yield steps "
                "(Actuate, Settle, Record, Scan, Note, Vent)"
            )
        return step

    def _failed(self, error: BaseException) -> ProcedureError:
        place = traceback.extract_tb(error.__traceback__)[-1]
        return ProcedureError(
            f"procedure {self._name} failed at step {self.index}: {type(error).__name__}: {error} "
            f"({Path(place.filename).name}, line {place.lineno})"
        )

    def close(self) -> None:
        """Let the procedure clean up; what goes wrong there is no longer of interest."""
        try:
            self._generator.close()
        except FAULTS:
            return
