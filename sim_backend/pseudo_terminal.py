"""A pseudo terminal that behaves as a serial port which outlives its clients."""

import contextlib
import ctypes
import fcntl
import os
import select
import struct
import termios

_CHUNK = 65536
# Numbers of asm-generic, so of x86 and ARM; Python's termios does not have them.
_TCGETS2, _TCSETS2 = 0x802C542A, 0x402C542B
_TIOCGEXCL = 0x80045440
_BOTHER = 0o010000  # the rate is the number in c_ospeed
_TERMIOS2 = struct.Struct("4IB19s2I")  # iflag, oflag, cflag, lflag, line, characters, ispeed, ospeed
_IN_CLOSE_WRITE = 0x08

_libc = ctypes.CDLL(None, use_errno=True)


class PseudoTerminal:
    """Both ends of a pty: a client opens `path`, this process reads and writes what the client writes and reads.

    The client's end is also kept open here: without it reads fail while there is no client. That keeps alive what
    a client leaves behind, so once the last one has gone, settings, exclusive use and unread bytes are undone.
    Only opening for reading alone tells our descriptor's closing from a client's.
    """

    def __init__(self, baud: int) -> None:
        """Open it, raw, at a baud rate."""
        self._initial_baud = baud
        self.master, slave = os.openpty()
        os.set_blocking(self.master, False)
        self.path = os.ttyname(slave)
        self._slave = self._open_slave()
        os.close(slave)
        self.departures = _watch_closing(self.path)  # readable when a client has closed
        self._settle()

    @property
    def baud(self) -> int:
        """The rate that is set on the client's end, of whatever kind; 0 is a hung-up line."""
        rate: int = _TERMIOS2.unpack(fcntl.ioctl(self._slave, _TCGETS2, bytes(_TERMIOS2.size)))[-1]
        return rate

    def read(self) -> bytes:
        """Return what was written to the client's end."""
        try:
            return os.read(self.master, _CHUNK)
        except BlockingIOError:
            return b""

    def write(self, data: bytes) -> None:
        """Let the client read bytes; those that do not fit in the terminal's buffer are lost."""
        with contextlib.suppress(BlockingIOError):
            os.write(self.master, data)

    def note_departures(self) -> bool:
        """Return whether the last client has gone. If so, all is as it was before the first one."""
        with contextlib.suppress(BlockingIOError):
            os.read(self.departures, _CHUNK)
        vacant = self.is_vacant()
        if vacant:
            self._settle()
        return vacant

    def is_vacant(self) -> bool:
        """Return whether no client is there: then closing our descriptor for a moment is a hang-up."""
        exclusive = any(fcntl.ioctl(self._slave, _TIOCGEXCL, bytes(4)))
        fcntl.ioctl(self._slave, termios.TIOCNXCL)  # or we could not open it again
        os.close(self._slave)
        poll = select.poll()
        poll.register(self.master, 0)
        vacant = any(events & select.POLLHUP for _, events in poll.poll(0))
        self._slave = self._open_slave()
        if exclusive and not vacant:
            fcntl.ioctl(self._slave, termios.TIOCEXCL)
        return vacant

    def close(self) -> None:
        """Hang up on the client."""
        for descriptor in (self.departures, self._slave, self.master):
            os.close(descriptor)

    def _open_slave(self) -> int:
        return os.open(self.path, os.O_RDONLY | os.O_NOCTTY)

    def _settle(self) -> None:
        """Be raw, at the initial baud rate, with nothing to read."""
        rate = getattr(termios, f"B{self._initial_baud}", _BOTHER)
        control = rate | termios.CS8 | termios.CREAD | termios.CLOCAL
        characters = bytearray(19)
        characters[termios.VMIN] = 1
        raw = _TERMIOS2.pack(0, 0, control, 0, 0, bytes(characters), self._initial_baud, self._initial_baud)
        fcntl.ioctl(self._slave, _TCSETS2, raw)
        termios.tcflush(self._slave, termios.TCIFLUSH)


def _watch_closing(path: str) -> int:
    """Return a descriptor that becomes readable when someone closes what they had open for writing."""
    watch: int = _libc.inotify_init1(os.O_NONBLOCK | os.O_CLOEXEC)
    if watch < 0 or _libc.inotify_add_watch(watch, os.fsencode(path), _IN_CLOSE_WRITE) < 0:
        error = ctypes.get_errno()
        raise OSError(error, os.strerror(error), path)
    return watch
