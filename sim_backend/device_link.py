"""A symbolic link to a terminal, owned by one living process."""

import contextlib
import fcntl
import os
from pathlib import Path

from robotwalk.errors import BusError, UsageError


class DeviceLink:
    """A link and beside it, in a hidden file, the lock of the process that serves it.

    The kernel drops the lock when a process dies however it dies: a link without a lock is stale.
    """

    def __init__(self, path: Path, target: str) -> None:
        """Point `path` at `target`, in place of a stale link.

        Raises:
            BusError: a living process serves under that name.
            UsageError: something else is there, or nothing can be made there.
        """
        self._path, self._target = path, target
        self._lock_path = path.with_name(f".{path.name}.lock")
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._lock = _lock(self._lock_path)
        except BlockingIOError as error:
            raise BusError(f"{path} is served by another robotwalk sim that still runs") from error
        except OSError as error:
            raise UsageError(f"cannot make {path}: {error.strerror}") from error
        try:
            self._point()
        except BaseException:
            self._unlock()
            raise

    def remove(self) -> None:
        """Remove the link, if it is still ours, and the lock."""
        with contextlib.suppress(OSError):
            if os.readlink(self._path) == self._target:
                self._path.unlink()
        self._unlock()

    def _point(self) -> None:
        if os.path.lexists(self._path) and not _points_at_terminal(self._path):
            raise UsageError(f"{self._path} is in the way, and no link to a pseudo terminal")
        fresh = self._path.with_name(f".{self._path.name}.new")
        fresh.unlink(missing_ok=True)
        fresh.symlink_to(self._target)
        fresh.replace(self._path)

    def _unlock(self) -> None:
        with contextlib.suppress(OSError):
            self._lock_path.unlink()
        os.close(self._lock)


def _points_at_terminal(path: Path) -> bool:
    return path.is_symlink() and os.readlink(path).startswith("/dev/pts/")


def _lock(path: Path) -> int:
    """Create a file, locked; return its descriptor.

    Raises:
        BlockingIOError: another process has it locked.
    """
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            # Its last owner may have removed it between the two calls: then it locks nothing.
            with contextlib.suppress(FileNotFoundError):
                if path.stat().st_ino == os.fstat(descriptor).st_ino:
                    return descriptor
        except OSError:
            os.close(descriptor)
            raise
        os.close(descriptor)
