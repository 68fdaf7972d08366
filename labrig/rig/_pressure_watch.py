"""Whether the chambers' readings still say that it is safe to go on: they come, and they are within the limits."""

from collections.abc import Sequence

from labrig.rig._asked import link_of
from labrig.rig._config import RigConfig
from labrig.rig._silence import Gaps, Silence, dated
from labrig_drivers import DeviceError, PressureSample


class PressureWatch:
    """Hears all that a controller called `name` measures; `latest` is the last of it."""

    def __init__(self, config: RigConfig, name: str, now_s: float) -> None:
        self._config, self._name = config, name
        # Of pressures simulated in this process only this process can be late: they have no link that may be dead.
        self._linked = bool(link_of(config))
        self._silence = Silence(now_s)
        self._gaps = Gaps([chamber.name for chamber in config.chambers], now_s)
        self.latest: PressureSample | None = None

    def hear(self, samples: Sequence[PressureSample], now_s: float) -> list[str]:
        """Take in what was measured; returns the chambers whose readings have begun to be none (NaN)."""
        if samples:
            self._silence.hear(samples[-1].time_s, now_s)
            self.latest = samples[-1]
        return [gap for sample in samples if (gap := self._gaps.take(sample.pressure_kpa, now_s))]

    def check(self, samples: Sequence[PressureSample], now_s: float) -> None:
        """Raise `DeviceError` where nothing was measured for too long, a chamber gives no reading any more, or one of
        these readings is beyond a limit.
        """
        limit_s = self._config.safety.stale_pressure_s
        silent_s = self._silence.lasts_s(now_s)
        if silent_s > limit_s and self._linked:
            what = dated(silent_s) if self._silence.behind(now_s) else f"no measurement for {silent_s:.1f} s"
            raise DeviceError(f"{self._name}: {what} (the limit is {limit_s:g} s); check its link")
        missing, missing_s = self._gaps.longer_than(limit_s, now_s)
        if missing:
            raise DeviceError(
                f"{self._name}: no reading (NaN) from {missing} for {missing_s:.1f} s "
                f"(the limit is {limit_s:g} s); check the sensors and their link"
            )
        for sample in samples:
            self._check_limits(sample)

    def _check_limits(self, sample: PressureSample) -> None:
        margin_kpa = self._config.safety.over_pressure_kpa
        for chamber, pressure_kpa in zip(self._config.chambers, sample.pressure_kpa, strict=True):
            for way, limit_kpa, beyond_kpa in (
                ("above", chamber.max_kpa, pressure_kpa - chamber.max_kpa),
                ("below", chamber.min_kpa, chamber.min_kpa - pressure_kpa),
            ):
                if beyond_kpa > margin_kpa:
                    raise DeviceError(
                        f"{self._name}: {chamber.name} reads {pressure_kpa:.1f} kPa, more than {margin_kpa:g} kPa "
                        f"{way} its limit of {limit_kpa:g} kPa"
                    )

    def forget(self, now_s: float) -> None:
        """Begin anew, after something that did not listen."""
        self._silence.forget(now_s)
        self._gaps.forget(now_s)
