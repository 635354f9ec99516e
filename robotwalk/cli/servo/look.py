"""`robotwalk servo scan` and `ping`: who is there."""

from typing import Any

from robotwalk.assembly import workbench
from robotwalk.cli.options import Json
from robotwalk.cli.output import complain, progress_line, say, write_json, write_table
from robotwalk.cli.servo.options import BAUD, Line, Port, Protocol, Real, ServoId, Servos
from robotwalk.errors import BusError


def scan(
    *, port: Port, baud: int | None = None, protocol: Protocol = None, real: Real = False, servos: Servos = None,
    json: Json = False,
) -> int:
    """Find every servo on a line: all ids, at every baud rate and in every protocol. Ctrl-C shows what was found.

    Parameters
    ----------
    baud
        Look at this baud rate only.
    """
    search = Search()
    models = workbench.load_servos(servos)
    with workbench.bench(
            port, baud=baud or BAUD, protocol=protocol, real=real, writes=False, servos=models) as bench:
        try:
            search.run(bench, [baud] if baud else bench.bauds())
        except KeyboardInterrupt:
            search.interrupted = True
    if json:
        write_json(search.fields())
    else:
        search.show()
    for sentence in search.complaints():
        complain(sentence)
    if search.interrupted:
        return 130
    return 0 if search.found or search.clashes else BusError.exit_code


def ping(servo_id: ServoId, /, *, line: Line, json: Json = False) -> None:
    """Ask one servo whether it is there, and who it is.

    """
    with line.reading() as bench:
        identity, seconds = bench.ping(servo_id)
    if json:
        write_json(identity_fields(identity) | {"round_trip_ms": round(1e3 * seconds, 3)})
        return
    firmware = f", firmware {identity.firmware}" if identity.firmware else ""
    say(f"id {identity.id}: {identity.name}{firmware}, {identity.protocol}; answered in {1e3 * seconds:.1f} ms")
    if identity.alert:
        complain(f"id {identity.id} reports a hardware error: see `robotwalk servo info {identity.id}`")


def identity_fields(identity: workbench.Identity) -> dict[str, Any]:
    """Return what a servo says of itself, for JSON."""
    fields = identity._asdict()
    del fields["twins"]
    return fields | {"model": identity.name if identity.model else None}


class Search:
    """What a scan has found so far."""

    def __init__(self) -> None:
        self.found: list[workbench.Identity] = []
        self.clashes: list[workbench.Clash] = []
        self.interrupted = False
        self._noise: list[workbench.Noise] = []
        self._refused: list[int] = []  # baud rates

    def run(self, bench: workbench.Bench, bauds: list[int]) -> None:
        """Look at each baud rate.

        Raises:
            BusError: the adapter has none of them.
        """
        with progress_line() as progress:
            for index, baud in enumerate(bauds):
                try:
                    bench.tune(baud)
                except BusError:
                    self._refused.append(baud)
                    if len(self._refused) == len(bauds):
                        raise
                    continue
                for finding in bench.scan():
                    self._note(finding)
                    share = finding.share if isinstance(finding, workbench.Progress) else 1.0
                    progress(f"{baud} baud, {len(self.found)} found", (index + share) / len(bauds))

    def _note(self, finding: workbench.Finding) -> None:
        match finding:
            case workbench.Identity():
                self.found.append(finding)
            case workbench.Clash():
                self.clashes.append(finding)
            case workbench.Noise() if finding not in self._noise:
                self._noise.append(finding)

    def complaints(self) -> list[str]:
        """Return what went wrong, in sentences."""
        sentences = [str(trouble) for trouble in (*self.clashes, *self._noise)]
        if self._refused:
            sentences.append(f"the adapter does not have {', '.join(map(str, self._refused))} baud")
        if self.interrupted:
            sentences.append("interrupted: not every baud rate was looked at")
        elif not self.found and not self.clashes:
            sentences.append("no servo answers. Is it powered, and is it on this port?")
        return sentences

    def fields(self) -> dict[str, Any]:
        """Return all of it, for JSON."""
        return {
            "servos": [identity_fields(identity) for identity in self.found],
            "clashes": [clash._asdict() for clash in self.clashes],
            "noisy_bauds": [noise.baud for noise in self._noise],
            "refused_bauds": self._refused,
            "complete": not self.interrupted,
        }

    def show(self) -> None:
        """Say it to a person."""
        if not self.found:
            return
        write_table(
            f"{len(self.found)} servo{'s' * (len(self.found) != 1)}",
            ["id", "model", "firmware", "baud", "protocol", "supply", "temperature", "hardware"],
            [
                [str(one.id), one.name, one.firmware or "", str(one.baud), one.protocol,
                 "" if one.voltage_v is None else f"{one.voltage_v:.1f} V",
                 "" if one.temperature_c is None else f"{one.temperature_c:.0f} degC",
                 "ERROR" if one.alert else "ok"]
                for one in self.found
            ])
