"""`robotwalk doctor`: is this computer fit to run a robot, and what mends it where it is not."""

import os
import re
from importlib import metadata
from typing import Any

from robotwalk.cli.options import Flag, Json
from robotwalk.cli.output import say, write_json
from robotwalk.doctor.checks import Finding, Level, diagnose
from robotwalk.doctor.computer import Computer
from robotwalk.doctor.remedy import Write


def doctor(*, fix: Flag = False, json: Json = False) -> int:
    """Look at this computer: kernel, governor, rights, processors, clock, serial adapters, packages.

    Each finding comes with why it matters and the command that mends it. Exits with 1 while there is a problem; what
    is only advised is none.

    Parameters
    ----------
    fix
        Mend what takes no more than writing a file: as root, `sudo "$(command -v robotwalk)" doctor --fix`. It says
        what it wrote, and does nothing else.
    """
    behind_sudo = os.environ.get("SUDO_UID", "") if os.geteuid() == 0 else ""
    computer, packages = Computer(asked_for=int(behind_sudo) if behind_sudo.isdecimal() else None), _packages()
    findings = diagnose(computer, packages)
    done: list[tuple[Write, str | None]] = []
    if fix:
        done = treat(computer, findings)
        findings = diagnose(computer, packages)
    if json:
        write_json({
            "ok": not any(finding.level is Level.PROBLEM for finding in findings),
            "findings": [_fields(finding) for finding in findings],
            "fixes": [{"path": write.path, "text": write.text, "failure": failure} for write, failure in done]})
    else:
        _show(findings, done)
    return 1 if any(finding.level is Level.PROBLEM for finding in findings) else 0


def treat(computer: Computer, findings: list[Finding]) -> list[tuple[Write, str | None]]:
    """Write what mends the findings; return what was tried, each with why it failed, or None."""
    writes = dict.fromkeys(
        write for finding in findings if finding.remedy is not None for write in finding.remedy.writes)
    # What stands there already waits for a login or a boot.
    return [
        (write, computer.write(write.path, write.text)) for write in writes if computer.text(write.path) != write.text]


def _packages() -> dict[str, str]:
    """Return the versions of all installed packages by their names, spelled as PyPI does."""
    return {
        re.sub(r"[-_.]+", "-", package.name).lower(): package.version for package in metadata.distributions()}


def _fields(finding: Finding) -> dict[str, Any]:
    remedy = finding.remedy
    return {
        "check": finding.check, "level": finding.level.value, "finding": finding.text, "why": finding.why,
        "fix": remedy and remedy.command, "in_force": (remedy and remedy.then) or None,
        "by_fix": bool(remedy and remedy.writes)}


def _show(findings: list[Finding], done: list[tuple[Write, str | None]]) -> None:
    for write, failure in done:
        if failure is None:
            say(f"wrote {write.text!r} to {write.path}")
        else:
            say(f"could not write {write.path}: {failure}")
    for finding in findings:
        mark = {Level.FINE: " ok ", Level.ADVICE: "hint", Level.PROBLEM: "FAIL"}[finding.level]
        say(f"{mark}  {finding.check:<9} {finding.text}")
        if finding.level is not Level.FINE:
            say(f"                {finding.why}")
        if finding.remedy is not None:
            when = f"   # {finding.remedy.then}" if finding.remedy.then else ""
            say(f"                $ {finding.remedy.command}{when}")
    by_fix = any(finding.remedy is not None and finding.remedy.writes for finding in findings)
    if by_fix and not done:
        say('sudo "$(command -v robotwalk)" doctor --fix writes these files itself')
