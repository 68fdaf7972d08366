"""Register maps of Modbus pressure regulators: a YAML file each, so that another one needs no code."""

from difflib import get_close_matches
from pathlib import Path
from typing import Literal

import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from labrig._yaml import SaidError, load_yaml

MAPS = Path(__file__).parent / "maps"
MAX_MAP_BYTES = 1 << 20

Table = Literal["holding", "input"]
Address = int


class RegisterMapError(ValueError):
    """A register map cannot be used; the message names the file and the field."""


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Registers(_Strict):
    """One register for each output, in order."""

    table: Table
    addresses: tuple[Address, ...] = Field(min_length=1, max_length=64)


class Register(_Strict):
    """One register with a name; `signed`: int16 in two's complement."""

    table: Table
    address: Address = Field(ge=0, le=65535)
    signed: bool = False


class Write(_Strict):
    """A value that is written to a holding register."""

    address: Address = Field(ge=0, le=65535)
    value: int = Field(ge=-32768, le=65535)


class Watchdog(Write):
    """The device's own: it brings every output to ambient when nobody has spoken to the device for `timeout_s`.

    Written at the start and read back.
    """

    timeout_s: float = Field(gt=0, le=3600)


class Gate(_Strict):
    """Outputs that act only while a program runs in their slot: written to `command`, seen in `status`."""

    table: Table = "holding"
    outputs_each: int = Field(ge=1)
    command: tuple[Address, ...]
    status: tuple[Address, ...]
    run: int
    rest: int
    acknowledge: int | None = None
    running_mask: int
    running: int
    timeout_s: float = Field(default=5.0, gt=0, le=60)


class RegisterMap(_Strict):
    """Where a regulator keeps set-points and measurements; counts are int16 of `kpa_per_count` kPa."""

    name: str
    tcp_port: int = Field(default=502, ge=1, le=65535)
    unit_id: int = Field(default=1, ge=0, le=247)
    kpa_per_count: float = Field(gt=0)
    range_kpa: tuple[float, float]
    setpoint: Registers
    measured: Registers
    start: tuple[Write, ...] = ()
    watchdog: Watchdog | None = None
    gate: Gate | None = None
    registers: dict[str, Register] = {}
    faults: tuple[str, ...] = ()

    @model_validator(mode="after")
    def _agree(self) -> "RegisterMap":
        outputs = len(self.setpoint.addresses)
        if self.setpoint.table != "holding":
            raise ValueError("setpoint: only holding registers can be written")
        if len(self.measured.addresses) != outputs:
            raise ValueError(f"measured: needs {outputs} addresses, one for each set-point")
        gate = self.gate
        if gate is not None and not len(gate.command) == len(gate.status) == -(-outputs // gate.outputs_each):
            raise ValueError(f"gate: {outputs} outputs need a command and a status each {gate.outputs_each}")
        for name in self.faults:
            if name not in self.registers:
                raise ValueError(f"faults: {name!r} is not among the registers")
        every = [*self.setpoint.addresses, *self.measured.addresses]
        if any(not 0 <= address <= 65535 for address in every):
            raise ValueError("addresses go from 0 to 65535")
        return self


def load_map(path: str | Path) -> RegisterMap:
    """Read a map; a bare name that is no file here is looked for among those that come with labrig."""
    given = Path(path)
    shipped = MAPS / given.name
    found = given if given.is_file() or given.parent != Path() or not shipped.is_file() else shipped
    try:
        if found.stat().st_size > MAX_MAP_BYTES:
            raise RegisterMapError(f"{found}: larger than any register map")
        data = load_yaml(found.read_text(encoding="utf-8"))
    except FileNotFoundError:
        names = ", ".join(sorted(file.name for file in MAPS.glob("*.yaml")))
        raise RegisterMapError(f"{given}: no such register map (labrig brings {names})") from None
    except SaidError as error:
        line = f", line {error.problem_mark.line + 1}" if error.problem_mark is not None else ""
        raise RegisterMapError(f"{found}{line}: {error.problem}") from None
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise RegisterMapError(f"{found}: cannot be read: {' '.join(str(error).split())}") from None
    try:
        return RegisterMap.model_validate(data)
    except ValidationError as error:
        raise RegisterMapError(_described(error, found)) from None


def _described(error: ValidationError, path: Path) -> str:
    """The first thing that is wrong in a map; of a name that is misspelt, the one that was meant."""
    first = error.errors()[0]
    where = ".".join(str(part) for part in first["loc"]) or "the map"
    what = first["msg"].removeprefix("Value error, ")
    if first["type"] == "extra_forbidden" or first["type"] == "missing":
        misspelt = [str(e["loc"][-1]) for e in error.errors() if e["type"] == "extra_forbidden"]
        lacking = [str(e["loc"][-1]) for e in error.errors() if e["type"] == "missing"]
        known = [*lacking, *RegisterMap.model_fields]
        near = [(name, close[0]) for name in misspelt if (close := get_close_matches(name, known, 1))]
        if near:
            where, what = near[0][0], f"there is no such field; did you mean {near[0][1]}?"
    return f"{path}: {where}: {what}"
