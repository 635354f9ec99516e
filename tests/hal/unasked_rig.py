"""A line on which a sensor talks unasked, in the test's hands."""

from robotwalk.errors import BusError

MS = 1_000_000


class Line:
    """A port and a clock in the test's hands."""

    def __init__(self) -> None:
        self.time = 0
        self.data = b""
        self.gone = False

    def now(self) -> int:
        return self.time

    def wait(self, ports: object, deadline: int) -> None:
        raise AssertionError("it must never wait")

    def fileno(self) -> int:
        return -1

    def waiting(self) -> int:
        return len(self.data)

    def write(self, data: bytes) -> None:
        raise AssertionError("nobody asked it to speak")

    def read(self) -> bytes:
        if self.gone:
            raise BusError("/dev/ttyUSB1 is gone: it ends")
        data, self.data = self.data, b""
        return data

    def close(self) -> None:
        pass
