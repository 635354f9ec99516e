"""What Linux tells of itself in /proc, /sys, /dev and /etc, to a process of ours."""

import os
import stat
from functools import cached_property
from pathlib import Path

SYS_NICE, IPC_LOCK = 23, 14  # linux/capability.h
_UNLIMITED = "unlimited"


class Computer:
    """Reads a computer's files, or those of a made-up one under another root. Paths are as the computer has them.

    Attributes:
        asked_for: the user whose rights are meant, if it is not this process's: the one who said `sudo`.
    """

    def __init__(self, root: Path = Path("/"), asked_for: int | None = None) -> None:
        self._root = root
        self.asked_for = asked_for

    def there(self, path: str) -> Path:
        """Return where a file of the computer really is."""
        return self._root / path.lstrip("/")

    def text(self, path: str) -> str | None:
        """Return what stands in a file, without white space around it; None if that cannot be had."""
        try:
            return self.there(path).read_text(errors="replace").strip().strip("\0")
        except OSError:
            return None

    def paths(self, pattern: str) -> list[str]:
        """Return the files that match a pattern, sorted."""
        found = self._root.glob(pattern.lstrip("/"))
        return sorted(f"/{path.relative_to(self._root)}" for path in found)

    def texts(self, pattern: str) -> dict[str, str]:
        """Return what stands in each file that matches a pattern."""
        texts = ((path, self.text(path)) for path in self.paths(pattern))
        return {path: text for path, text in texts if text is not None}

    def may(self, capability: int) -> bool:
        """Tell whether this process has a capability."""
        return bool(int(self._status.get("CapEff", "0"), 16) >> capability & 1)

    def limit(self, name: str) -> float:
        """Return a limit of this process that is in force, by its name in /proc/self/limits; 0 if there is none."""
        for line in (self.text("/proc/self/limits") or "").splitlines():
            if line.startswith(name):
                value = line[len(name):].split()[0]
                return float("inf") if value == _UNLIMITED else float(value)
        return 0.0

    def usable(self, path: str) -> bool:
        """Tell whether this process may read and write a file, by its owner, group and mode."""
        if self._user == 0:
            return True
        file = self.there(path).stat()
        if file.st_uid == self._user:
            return bool(file.st_mode & stat.S_IRUSR and file.st_mode & stat.S_IWUSR)
        if file.st_gid in self._groups:
            return bool(file.st_mode & stat.S_IRGRP and file.st_mode & stat.S_IWGRP)
        return bool(file.st_mode & stat.S_IROTH and file.st_mode & stat.S_IWOTH)

    def group_of(self, path: str) -> str:
        """Return the name of a file's group."""
        number = self.there(path).stat().st_gid
        return next((name for name, _, group, _ in self._rows("/etc/group") if group == str(number)), str(number))

    def write(self, path: str, text: str) -> str | None:
        """Have a text, and a line end, stand in a file; return why that cannot be."""
        try:
            self.there(path).write_text(f"{text}\n")
        except OSError as error:
            return os.strerror(error.errno) if error.errno else str(error)
        return None

    @cached_property
    def _status(self) -> dict[str, str]:
        rows = (line.partition(":") for line in (self.text("/proc/self/status") or "").splitlines())
        return {name: value.strip() for name, _, value in rows}

    @cached_property
    def _user(self) -> int:
        return int(self._status["Uid"].split()[1]) if self.asked_for is None else self.asked_for

    @cached_property
    def _groups(self) -> set[int]:
        if self.asked_for is None:
            return {int(self._status["Gid"].split()[1]), *map(int, self._status["Groups"].split())}
        groups, names = set(), set()
        for name, _, user, group, *_ in self._rows("/etc/passwd"):
            if int(user) == self.asked_for:
                groups.add(int(group))
                names.add(name)
        groups.update(
            int(group) for _, _, group, members in self._rows("/etc/group") if names.intersection(members.split(",")))
        return groups

    def _rows(self, path: str) -> list[list[str]]:
        return [line.split(":") for line in (self.text(path) or "").splitlines() if ":" in line]
