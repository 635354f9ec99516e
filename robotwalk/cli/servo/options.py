"""What all these commands are told: where the servos are, and how to answer."""

import shlex
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from robotwalk.assembly import workbench

BAUD = 1_000_000
_LARGEST_ID = 252


def _check_id(kind: Any, servo_id: int | None) -> None:
    if servo_id is not None and not 0 <= servo_id <= _LARGEST_ID:
        raise ValueError(f"an id is 0 to {_LARGEST_ID}, not {servo_id}")


ServoId = Annotated[int, Parameter(validator=_check_id, help=f"0 to {_LARGEST_ID}.")]
Port = Annotated[str, Parameter(help="The line: /dev/ttyUSB0, socket://host:port, or a bus of `robotwalk sim`.")]
Protocol = Annotated[
    workbench.ProtocolName | None,
    Parameter(help="What the servos speak. Default: found out by asking.")]
Baud = Annotated[int, Parameter(help="The line's baud rate.")]
Servos = Annotated[Path | None, Parameter(help="A folder with files of servos that are not bundled.")]
Real = Annotated[bool, Parameter(negative="", help="Allow this on a physical servo.")]


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Line:
    """A line that is only read from."""

    port: Port
    baud: Baud = BAUD
    protocol: Protocol = None
    real: Real = False
    servos: Servos = None

    @cached_property
    def models(self) -> dict[str, workbench.ServoModel]:
        """The models that may be there."""
        return workbench.load_servos(self.servos)

    def words(self, baud: int) -> str:
        """Return what to type for this line at a baud rate."""
        own = f"--servos {shlex.quote(str(self.servos))}" if self.servos else ""
        parts = [f"--port {shlex.quote(self.port)}", f"--baud {baud}" * (baud != BAUD), "--real" * self.real, own]
        return " ".join(filter(None, parts))

    def reading(self) -> AbstractContextManager[workbench.Bench]:
        """Open it, to look only."""
        return self._open(writes=False)

    def writing(self) -> AbstractContextManager[workbench.Bench]:
        """Open it, to change something. Raises UsageError if that may be a physical servo and nobody said so."""
        return self._open(writes=True)

    def _open(self, *, writes: bool) -> AbstractContextManager[workbench.Bench]:
        return workbench.bench(
            self.port, baud=self.baud, protocol=self.protocol, real=self.real, writes=writes, servos=self.models)
