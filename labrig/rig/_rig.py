"""A connected rig: it is vented before it is let go, however that happens."""

from dataclasses import dataclass, field
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from labrig._own_code import FAULTS
from labrig.rig._config import RigConfig
from labrig.rig._last_words import and_vented, not_vented
from labrig_drivers import (
    Clock,
    Device,
    Identity,
    MotionCapture,
    PressureController,
    Scanner,
    VentNotConfirmedError,
    VentReport,
)


@dataclass
class Rig:
    """The connected devices of a rig; a context manager that vents, confirms it, and then closes."""

    config: RigConfig
    clock: Clock
    pressure: PressureController
    mocap: MotionCapture | None = None
    scanner: Scanner | None = None
    identity: dict[str, Identity] = field(default_factory=dict)
    plant_rest_mm: NDArray[np.float64] | None = None

    @property
    def devices(self) -> list[Device]:
        """What is there of pressure, mocap and scanner."""
        return [device for device in (self.pressure, self.mocap, self.scanner) if device is not None]

    @property
    def rest_mm(self) -> NDArray[np.float64] | None:
        """Where the markers are when every chamber is vented, (M, 3) mm, if rig.yaml or the plant says so.

        None without markers: a plant has them even where no camera looks at it.
        """
        if not self.config.markers:
            return None
        if self.config.rest_mm is not None:
            unknown = (np.nan,) * 3
            rest = [self.config.rest_mm.get(name, unknown) for name in self.config.markers]
            return np.array(rest, float).reshape(-1, 3)
        return None if self.plant_rest_mm is None else np.array(self.plant_rest_mm, float)

    def thinking(self) -> None:
        """Say that a procedure's own code runs now: the guard, if there is one, allows it `think_s`."""
        if (allow := getattr(self.pressure, "allow_silence", None)) is not None:
            allow(self.config.safety.think_s)

    def vent(self) -> VentReport:
        """Bring every chamber to ambient; raises `VentNotConfirmedError` if reading does not confirm it."""
        return self.pressure.vent(self.config.safety.vent_timeout_s)

    def close(self) -> None:
        """Release every link, the pressure's last; never raises."""
        for device in reversed(self.devices):
            device.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Vent, close, and say with whatever ended it whether the chambers are vented."""
        try:
            self.vent()
        except FAULTS as problem:
            if isinstance(error, VentNotConfirmedError):  # it says so already
                return
            raise not_vented(problem, error) from (error or problem)
        finally:
            self.close()
        simulated = self.config.pressure.kind == "simulated"  # nothing is under pressure
        if error is not None and not simulated and (said := and_vented(error)) is not error:
            raise said from error
