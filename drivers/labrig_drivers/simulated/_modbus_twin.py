"""A Modbus pressure regulator over the plant: a real pymodbus server with the registers of a map."""

import asyncio
import threading
import time
from typing import Any

import numpy as np

from labrig_drivers._modbus import from_counts, to_counts
from labrig_drivers._modbus_map import RegisterMap
from labrig_drivers.simulated._wire_plant import SharedPlant

START_S = 5.0


class ModbusTwin:
    """Serves a map's registers over TCP, or RTU on `serial` (a device path). `port` 0 takes a free one.

    Set-points act while every `start` register holds its value and, with a gate, the slot's program runs. A watchdog
    that was set forgets them when no request came for its time.
    `outputs` are the map's outputs that the plant's chambers are on.
    """

    def __init__(
        self,
        plant: SharedPlant,
        registers: RegisterMap,
        *,
        outputs: tuple[int, ...] | None = None,
        host: str = "127.0.0.1",
        port: int = 0,
        serial: str | None = None,
        baudrate: int = 19200,
    ) -> None:
        self.host, self.port = host, port
        self._plant = plant
        self._map = registers
        self._outputs = tuple(range(len(plant.channels))) if outputs is None else outputs
        self._serial, self._baudrate = serial, baudrate
        self._holding: dict[int, int] = {}
        self._heard_at = time.monotonic()
        self._lock = threading.Lock()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._server: Any = None
        self._thread: threading.Thread | None = None
        self._started = threading.Event()
        self._failure: BaseException | None = None
        self.faults: dict[str, int] = {}

    def start(self) -> "ModbusTwin":
        """Listen and serve from a thread."""
        self._started.clear()
        self._thread = threading.Thread(target=self._run, name="modbus-twin", daemon=True)
        self._thread.start()
        self._started.wait(START_S)
        if self._failure is not None:
            self._thread.join()
            raise self._failure
        return self

    def stop(self) -> None:
        """Close every connection and end the thread."""
        loop, thread = self._loop, self._thread
        if thread is None or loop is None:
            return
        asyncio.run_coroutine_threadsafe(self._server.shutdown(), loop).result(START_S)
        thread.join()
        self._thread = None

    def _run(self) -> None:
        try:
            asyncio.run(self._serve())
        except BaseException as error:
            self._failure = error
        finally:
            self._started.set()

    async def _serve(self) -> None:
        from pymodbus.server import ModbusSerialServer, ModbusTcpServer

        self._loop = asyncio.get_running_loop()
        if self._serial:
            self._server = ModbusSerialServer(self._device(), port=self._serial, baudrate=self._baudrate)
        else:
            self._server = ModbusTcpServer(self._device(), address=(self.host, self.port))
        await self._server.serve_forever(background=True)
        if not self._serial:
            self.port = self._server.transport.sockets[0].getsockname()[1]
        self._started.set()
        watching = asyncio.create_task(self._watch())
        await self._server.serving
        watching.cancel()
        await asyncio.sleep(0)

    async def _watch(self) -> None:
        """The device's watchdog: outputs to ambient when nobody speaks to it any more."""
        watchdog = self._map.watchdog
        while watchdog is not None:
            await asyncio.sleep(watchdog.timeout_s / 10)
            silent_s = time.monotonic() - self._heard_at
            with self._lock:
                bites = (
                    self._holding.get(watchdog.address) == watchdog.value and silent_s > watchdog.timeout_s
                )
                for address in self._map.setpoint.addresses if bites else ():
                    self._holding[address] = 0
            if bites:
                self._plant.command(self._acting_kpa())

    def _addresses(self, table: str) -> list[int]:
        found = {register.address for register in self._map.registers.values() if register.table == table}
        for registers in (self._map.setpoint, self._map.measured):
            if registers.table == table:
                found.update(registers.addresses)
        if table == "holding":
            found.update(step.address for step in self._map.start)
            found.update([self._map.watchdog.address] if self._map.watchdog is not None else [])
        if self._map.gate is not None:
            if table == "holding":
                found.update(self._map.gate.command)
            if table == self._map.gate.table:
                found.update(self._map.gate.status)
        return sorted(found)

    def _device(self) -> Any:
        from pymodbus.simulator import DataType, SimData, SimDevice

        def block(table: str) -> list[Any]:
            addresses = self._addresses(table) or [0]
            first, last = addresses[0], addresses[-1]
            return [SimData(first, count=last - first + 1, values=0, datatype=DataType.REGISTERS)]

        bits = [SimData(0, count=16, values=False, datatype=DataType.BITS)]
        return SimDevice(
            id=self._map.unit_id,
            simdata=(bits, list(bits), block("holding"), block("input")),
            action=self._action,
        )

    async def _action(
        self,
        function_code: int,
        start_address: int,
        address: int,
        count: int,
        current_registers: list[int],
        set_values: list[int] | list[bool] | None,
    ) -> None:
        self._heard_at = time.monotonic()
        if function_code in (3, 4) and set_values is None:
            table = "input" if function_code == 4 else "holding"
            now = self._read_all(table)
            for at in range(address, address + count):
                current_registers[at - start_address] = now.get(at, 0)
        elif function_code in (6, 16) and set_values is not None:
            with self._lock:
                for offset, value in enumerate(set_values):
                    self._holding[address + offset] = int(value) & 0xFFFF
            self._plant.command(self._acting_kpa())

    def _read_all(self, table: str) -> dict[int, int]:
        values: dict[int, int] = {}
        with self._lock:
            if table == "holding":
                values.update(self._holding)
        if table == self._map.measured.table:
            scale = self._map.kpa_per_count
            for output, kpa in zip(self._outputs, self._plant.pressure_kpa().tolist(), strict=True):
                limit = 32767 * scale
                values[self._map.measured.addresses[output]] = to_counts(min(max(kpa, -limit), limit), scale)
        gate = self._map.gate
        if gate is not None and table == gate.table:
            for command, status in zip(gate.command, gate.status, strict=True):
                app = self._holding.get(command, gate.rest) & 0x3F
                values[status] = app | (gate.running if app == gate.run else 0)
        for name, value in self.faults.items():
            if self._map.registers[name].table == table:
                values[self._map.registers[name].address] = value
        return values

    def _acting_kpa(self) -> np.ndarray:
        with self._lock:
            on = all(self._holding.get(step.address) == step.value & 0xFFFF for step in self._map.start)
            gate = self._map.gate
            acting = np.zeros(len(self._outputs))
            low, high = self._map.range_kpa
            for index, output in enumerate(self._outputs):
                open_ = gate is None or (
                    self._holding.get(gate.command[output // gate.outputs_each], 0) & 0x3F == gate.run
                )
                if on and open_:
                    register = self._holding.get(self._map.setpoint.addresses[output], 0)
                    acting[index] = min(max(from_counts(register, self._map.kpa_per_count), low), high)
            return acting
