"""Byte links to devices: TCP and serial ports, every call bounded in time."""

import contextlib
import os
import socket
import time
from typing import Protocol
from urllib.parse import urlsplit

READ_BYTES = 65536
SERIAL_WAIT_S = 0.02


class LinkError(OSError):
    """A link could not be opened, or was lost; the message says which one and why, in one line."""


class Link(Protocol):
    """A stream of bytes to a device and back."""

    def read(self, timeout_s: float) -> bytes:
        """What has arrived, waiting at most `timeout_s` for the first byte; empty when nothing came."""
        ...

    def write(self, data: bytes) -> None:
        """Send all of `data` within the link's write timeout."""
        ...

    def close(self) -> None:
        """Release the link; never raises."""
        ...


class TcpLink:
    """A TCP connection. `LinkError` when it cannot be opened in `timeout_s`, or is lost."""

    def __init__(self, host: str, port: int, timeout_s: float = 3.0) -> None:
        self._where = f"{host}:{port}"
        try:
            self._socket = socket.create_connection((host, port), timeout_s)
        except TimeoutError:
            raise LinkError(
                f"nothing answers at {self._where} within {timeout_s:g} s (is the address right, and the "
                "device switched on?)"
            ) from None
        except ConnectionRefusedError:
            raise LinkError(
                f"{self._where} refuses the connection (nothing listens on that port; is the server running?)"
            ) from None
        except (OSError, UnicodeError, OverflowError) as error:
            raise LinkError(f"cannot connect to {self._where}: {_reason(error)}") from None
        self._timeout_s = timeout_s
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def read(self, timeout_s: float) -> bytes:
        """What has arrived, waiting at most `timeout_s`."""
        try:
            self._socket.settimeout(max(0.0, timeout_s))
            data = self._socket.recv(READ_BYTES)
        except (TimeoutError, BlockingIOError):
            return b""
        except OSError as error:
            raise LinkError(f"lost the connection to {self._where}: {_reason(error)}") from None
        if not data:
            raise LinkError(f"{self._where} closed the connection")
        return data

    def write(self, data: bytes) -> None:
        """Send all of `data`."""
        try:
            self._socket.settimeout(self._timeout_s)
            self._socket.sendall(data)
        except TimeoutError:
            raise LinkError(f"{self._where} does not take what is sent to it") from None
        except OSError as error:
            raise LinkError(f"lost the connection to {self._where}: {_reason(error)}") from None

    def close(self) -> None:
        """Close the connection."""
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()


class SerialLink:
    """A serial port of any system (``COM3``, ``/dev/ttyUSB0``, ``rfc2217://...``), through pyserial."""

    def __init__(self, port: str, baudrate: int = 115200, timeout_s: float = 3.0) -> None:
        import serial

        self._where = port
        self._errors = (serial.SerialException, OSError, ValueError, TypeError)
        try:
            self._serial = serial.serial_for_url(
                port,
                baudrate=baudrate,
                timeout=SERIAL_WAIT_S,
                write_timeout=timeout_s,
                exclusive=_exclusive(port),
            )
        except self._errors as error:
            raise LinkError(f"cannot open the serial port {port}: {_reason(error)}") from None

    def read(self, timeout_s: float) -> bytes:
        """What has arrived, waiting at most `timeout_s`, to within `SERIAL_WAIT_S`."""
        # The port's own timeout stays as it is: to change it would configure the port anew each time.
        deadline = time.monotonic() + timeout_s
        try:
            while True:
                waiting = self._serial.in_waiting
                if waiting:
                    return self._serial.read(min(waiting, READ_BYTES))
                if time.monotonic() >= deadline:
                    return b""
                if first := self._serial.read(1):
                    return first + self._serial.read(min(self._serial.in_waiting, READ_BYTES))
        except self._errors as error:
            raise LinkError(f"lost the serial port {self._where}: {_reason(error)}") from None

    def write(self, data: bytes) -> None:
        """Send all of `data`."""
        try:
            self._serial.write(data)
        except self._errors as error:
            raise LinkError(f"lost the serial port {self._where}: {_reason(error)}") from None

    def close(self) -> None:
        """Close the port."""
        with contextlib.suppress(*self._errors):
            self._serial.close()


def open_link(address: str, baudrate: int = 115200, timeout_s: float = 3.0) -> Link:
    """Open ``socket://HOST:PORT`` or a serial port.

    A socket is opened directly, not through pyserial's `socket://` handler, which hands out one byte at a
    time when it is read without waiting.
    """
    if not address.lower().startswith("socket://"):
        return SerialLink(address, baudrate, timeout_s)
    try:
        parts = urlsplit(address)
        host, port = parts.hostname, parts.port
    except ValueError:
        host = port = None
    if not host or not port:
        raise LinkError(f"{address!r} is no address: write socket://HOST:PORT")
    return TcpLink(host, port, timeout_s)


def _exclusive(port: str) -> bool | None:
    # Only POSIX serial ports can be locked against a second opener; Windows ports always are.
    return True if port.startswith("/dev/") else None


def _reason(error: BaseException) -> str:
    number = getattr(error, "errno", None)
    if isinstance(number, int) and number > 0 and os.name != "nt":  # where sockets' numbers have no names
        text = os.strerror(number)
    else:
        text = getattr(error, "strerror", None) or str(error)
    return " ".join((text or type(error).__name__).split())
