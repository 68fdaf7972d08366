"""The settings of each kind of device, as they stand in a rig file."""

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, field_validator


class Settings(BaseModel):
    """Settings that refuse what they do not know."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class PressureSettings(Settings):
    """What all pressure controllers share."""

    outputs: tuple[int, ...] | None = Field(default=None, description="the device's channel of each chamber")
    stale_after_s: float = Field(default=1.0, gt=0)
    over_kpa: float = Field(default=10.0, ge=0)
    vent_below_kpa: float = Field(default=3.0, gt=0)
    timeout_s: float = Field(default=3.0, gt=0, le=60)


class OpenPneuSettings(PressureSettings):
    """`kind: openpneu`: a serial port (or ``socket://HOST:PORT``), and which firmware the board runs."""

    port: str
    dialect: Literal["auto", "published", "table"] = "auto"
    build: Literal["published", "full"] = "published"
    baudrate: int = Field(default=115200, gt=0)
    boot_s: float = Field(default=1.5, ge=0, le=30)


class ModbusSettings(PressureSettings):
    """`kind: modbus`: a host, or a serial port for RTU, and the regulator's register map."""

    map: str
    host: str | None = None
    port: int | None = Field(default=None, ge=1, le=65535)
    serial: str | None = None
    baudrate: int = Field(default=19200, gt=0)
    parity: Literal["N", "E", "O"] = "N"
    unit_id: int | None = Field(default=None, ge=0, le=247)
    timeout_s: float = Field(default=1.0, gt=0, le=60)
    poll_hz: float = Field(default=20.0, gt=0, le=200)


class ViconSettings(Settings):
    """`kind: vicon`: the DataStream server, the subject, and the axis that labrig shall see as up."""

    host: str = "127.0.0.1"
    port: int = Field(default=801, ge=1, le=65535)
    subject: str | None = None
    up: Literal["y", "z"] = "z"
    unit: Literal["mm", "m"] = "mm"
    rename: dict[str, str] = {}
    mode: Literal["push", "pull", "prefetch"] = "push"
    timeout_s: float = Field(default=5.0, gt=0, le=60)
    stale_after_s: float = Field(default=0.25, gt=0, le=60)
    lost_after_s: float = Field(default=30.0, gt=0)


class ArtecSettings(Settings):
    """`kind: artec`: the folder that Artec Studio exports into, and the unit that is set there."""

    folder: str
    unit: Literal["mm", "cm", "m", "inch"]
    formats: tuple[Literal["obj", "ply", "stl", "xyz"], ...] = ("obj", "ply", "stl", "xyz")
    size_mm: tuple[float, float] = (50.0, 3000.0)
    settle_s: float = Field(default=1.0, gt=0, le=60)
    stall_s: float = Field(default=10.0, gt=0, le=600)

    @field_validator("size_mm")
    @classmethod
    def _from_small_to_large(cls, value: tuple[float, float]) -> tuple[float, float]:
        if not 0.0 < value[0] < value[1]:
            raise ValueError(f"should be the least and the most mm across, not {value[0]:g} and {value[1]:g}")
        return value


SETTINGS: dict[str, type[Settings]] = {
    "openpneu": OpenPneuSettings,
    "modbus": ModbusSettings,
    "vicon": ViconSettings,
    "artec": ArtecSettings,
}
