"""Modbus pressure regulators over TCP or RTU, through pymodbus, as a `PressureWire`."""

import contextlib
import logging
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from labrig_drivers._modbus_map import RegisterMap, Table
from labrig_drivers._pressure_wire import WireError
from labrig_drivers._recording import Recorder
from labrig_drivers._transport import LinkError

MAX_SPAN = 125  # registers in one read
MAX_GAP = 4  # registers that are read along rather than asked for in a second request
FAULTS_EVERY_S = 1.0

# What pymodbus would print about a lost connection is in our errors already.
logging.getLogger("pymodbus").addHandler(logging.NullHandler())


@dataclass(frozen=True)
class ModbusOptions:
    """How to reach a regulator: `host` and `tcp_port`, or `serial` for RTU; times in s.

    `outputs` are the map's outputs in the order of the chambers.
    """

    registers: RegisterMap
    outputs: tuple[int, ...]
    host: str | None = None
    tcp_port: int = 502
    serial: str | None = None
    baudrate: int = 19200
    parity: str = "N"
    unit_id: int = 1
    timeout_s: float = 1.0
    poll_hz: float = 20.0

    @property
    def where(self) -> str:
        """The regulator's address, as errors name it."""
        return self.serial or f"{self.host}:{self.tcp_port}"


def to_counts(value_kpa: float, kpa_per_count: float) -> int:
    """A pressure as the register holds it: int16 in two's complement. `WireError` where it does not fit."""
    counts = round(value_kpa / kpa_per_count)
    if not -32768 <= counts <= 32767:
        raise WireError(f"{value_kpa:g} kPa does not fit an int16 of {kpa_per_count:g} kPa")
    return counts & 0xFFFF


def from_counts(register: int, kpa_per_count: float) -> float:
    """The pressure, kPa, in a register."""
    return signed(register) * kpa_per_count


def signed(register: int) -> int:
    """A register as int16."""
    return (register & 0xFFFF) - 0x10000 if register & 0x8000 else register & 0xFFFF


def spans(addresses: Sequence[int]) -> list[tuple[int, int]]:
    """(first address, count) of the reads that cover `addresses`."""
    found: list[tuple[int, int]] = []
    for address in sorted(set(addresses)):
        if found:
            first, count = found[-1]
            if address - (first + count) <= MAX_GAP and address - first < MAX_SPAN:
                found[-1] = (first, address - first + 1)
                continue
        found.append((address, 1))
    return found


class ModbusWire:
    """Speaks to a regulator as its register map says."""

    def __init__(self, options: ModbusOptions, recorder: Recorder | None = None) -> None:
        self._options = options
        self._map = options.registers
        self._recorder = recorder
        self._client: Any = None
        self._written: dict[int, int] = {}
        self._next_poll = 0.0
        self._next_faults = 0.0
        self._received = b""

    def open(self) -> None:
        """Connect, set 0 on every output that is used, and let them act."""
        options = self._options
        trace: dict[str, Any] = {"trace_packet": self._trace} if self._recorder is not None else {}
        if options.serial:
            from pymodbus.client import ModbusSerialClient

            self._client = ModbusSerialClient(
                options.serial,
                baudrate=options.baudrate,
                parity=options.parity,
                timeout=options.timeout_s,
                retries=0,
                **trace,
            )
        else:
            from pymodbus.client import ModbusTcpClient

            self._client = ModbusTcpClient(
                options.host or "",
                port=options.tcp_port,
                timeout=options.timeout_s,
                retries=1,
                **trace,
            )
        self._written.clear()
        if not self._call(self._client.connect):
            raise LinkError(
                f"no Modbus device answers at {options.where} within {options.timeout_s:g} s "
                "(right address, switched on?)"
            )
        self.write(np.zeros(len(options.outputs)))
        for step in self._map.start:
            self._write(step.address, step.value & 0xFFFF)
        self._set_watchdog()
        self._open_gates()

    def identify(self) -> tuple[str, dict[str, str]]:
        """The map's name, and what its named registers read."""
        details = {}
        for name, register in self._map.registers.items():
            value = self._read(register.table, register.address, 1)[0]
            details[name] = str(signed(value) if register.signed else value)
        if self._map.watchdog is not None:
            details["watchdog"] = f"{self._map.watchdog.timeout_s:g} s"
        return f"{self._map.name} at {self._options.where}, unit {self._options.unit_id}", details

    def write(self, pressure_kpa: NDArray[np.float64]) -> None:
        """Write the set-points that changed."""
        if pressure_kpa.any():
            self._next_faults = min(self._next_faults, time.monotonic())
        for output, value in zip(self._options.outputs, pressure_kpa.tolist(), strict=True):
            counts = to_counts(value, self._map.kpa_per_count)
            if self._written.get(output) != counts:
                self._write(self._map.setpoint.addresses[output], counts)
                self._written[output] = counts

    def poll(self, timeout_s: float) -> list[NDArray[np.float64]]:
        """One reading of all outputs, at `poll_hz`; nothing in between."""
        now = time.monotonic()
        if now < self._next_poll:
            time.sleep(min(timeout_s, self._next_poll - now))
            return []
        self._next_poll = max(self._next_poll + 1.0 / self._options.poll_hz, now)
        addresses = [self._map.measured.addresses[output] for output in self._options.outputs]
        values: dict[int, int] = {}
        for first, count in spans(addresses):
            registers = self._read(self._map.measured.table, first, count)
            values.update(zip(range(first, first + count), registers, strict=True))
        if now >= self._next_faults:
            self._next_faults = now + FAULTS_EVERY_S
            self._check_faults()
        scale = self._map.kpa_per_count
        return [np.array([from_counts(values[address], scale) for address in addresses])]

    def stop(self) -> None:
        """Set-points 0: these regulators bring their outputs to ambient themselves.

        Whether they report a fault is looked at again with the next set-point above: it must not hide what is read now.
        """
        self._next_faults = math.inf
        self._written.clear()
        self.write(np.zeros(len(self._options.outputs)))

    def close(self) -> None:
        """Set-points 0; release the link. The programs run on: a slot that is off would keep its pressure."""
        client = self._client
        if client is None:
            return
        with contextlib.suppress(LinkError, WireError):
            if client.connected:
                self.stop()
        self._client = None
        with contextlib.suppress(Exception):
            client.close()

    def _slots(self) -> list[int]:
        each = self._map.gate.outputs_each if self._map.gate else 1
        return sorted({output // each for output in self._options.outputs})

    def _set_watchdog(self) -> None:
        watchdog = self._map.watchdog
        if watchdog is None:
            return
        self._write(watchdog.address, watchdog.value & 0xFFFF)
        kept = self._read("holding", watchdog.address, 1)[0]
        if kept != watchdog.value & 0xFFFF:
            raise WireError(
                f"{self._map.name} at {self._options.where} does not keep its watchdog: register "
                f"{watchdog.address} reads {kept} after {watchdog.value} was written"
            )

    def _open_gates(self) -> None:
        gate = self._map.gate
        if gate is None:
            return
        for index in self._slots():
            if gate.acknowledge is not None:
                self._write(gate.command[index], gate.acknowledge)
            self._write(gate.command[index], gate.run)
        deadline = time.monotonic() + gate.timeout_s
        for index in self._slots():
            while True:
                status = self._read(gate.table, gate.status[index], 1)[0]
                if status & gate.running_mask == gate.running:
                    break
                if time.monotonic() > deadline:
                    raise WireError(
                        f"{self._map.name} at {self._options.where}: slot {index} does not start (status "
                        f"0x{status:02x} in register {gate.status[index]} after {gate.timeout_s:g} s)"
                    )
                time.sleep(0.02)

    def _check_faults(self) -> None:
        for name in self._map.faults:
            register = self._map.registers[name]
            value = self._read(register.table, register.address, 1)[0]
            if value:
                raise WireError(
                    f"{self._map.name} at {self._options.where} reports {name} {value} "
                    f"(register {register.address}; its manual says what that is)"
                )

    def _read(self, table: Table, address: int, count: int) -> list[int]:
        name = "read_input_registers" if table == "input" else "read_holding_registers"
        read = getattr(self._client, name)
        answer = self._call(lambda: read(address, count=count, device_id=self._options.unit_id))
        self._refused(answer, f"reading {table} register {address}")
        registers = list(answer.registers)
        if len(registers) != count:
            raise WireError(
                f"{self._options.where} sent {len(registers)} of {count} registers from {address} on"
            )
        return registers

    def _write(self, address: int, value: int) -> None:
        answer = self._call(
            lambda: self._client.write_register(address, value, device_id=self._options.unit_id)
        )
        self._refused(answer, f"writing holding register {address}")

    def _refused(self, answer: Any, what: str) -> None:
        if answer.isError():
            code = getattr(answer, "exception_code", None)
            raise WireError(
                f"{self._options.where} refuses {what} (Modbus exception {code}): is this the right map and "
                f"unit? ({self._map.name}, unit {self._options.unit_id})"
            )

    def _call(self, call: Callable[[], Any]) -> Any:
        from pymodbus.exceptions import ModbusException, ModbusIOException

        if self._client is None:
            raise LinkError("the link is not open")
        try:
            try:
                return call()
            except ModbusIOException:
                if not self._options.serial:
                    raise
                # An answer over RTU does not say to what: a late one has to be in before the next request, with
                # which the library throws it away.
                time.sleep(self._options.timeout_s)
                return call()
        except ModbusException as error:
            why = " ".join(str(error).removeprefix("Modbus Error: ").split())
            if "unexpectedly closed" in why:  # and how many bytes of what were in by then
                why = "it closed the connection; is it on, and its cable in?"
            raise LinkError(f"lost the Modbus device at {self._options.where}: {why}") from None
        except (OSError, ValueError, TypeError, IndexError, KeyError, AttributeError) as error:
            # A damaged answer can fail anywhere inside the library.
            raise LinkError(
                f"the Modbus device at {self._options.where} sent nonsense: {type(error).__name__}: {error}"
            ) from None

    def _trace(self, sending: bool, data: bytes) -> bytes:
        # The library shows all it holds of an answer each time a part of it comes in.
        if self._recorder is not None:
            if sending:
                self._received = b""
                self._recorder.piece(True, data)
            else:
                new = data[len(self._received) :] if data.startswith(self._received) else data
                self._received = data
                self._recorder.piece(False, new)
        return data
