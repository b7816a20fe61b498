"""A substitute for a sandbox: an ordinary process with resource limits, for trusted code."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass

from grader.sandbox.launcher import launch
from grader.sandbox.protocol import Limits, Worker


@dataclass(frozen=True)
class PlainProcess:
    """A process without a sandbox, for the demo and students' own machines, not untrusted code."""

    name: str = "process"
    warning: str = (
        "WARNING: no sandbox (--sandbox process). Submitted code runs under your account. It can "
        "read and delete your files, use the network and look at other submissions. Use this only "
        "for code that you trust."
    )

    def check_available(self) -> None:
        """Do nothing, because nothing has to be installed."""

    def label(self) -> str:
        """Return "no sandbox"; see `grader.sandbox.protocol.Sandbox`."""
        return "no sandbox"

    def protections(self) -> str:
        """Return "none", because there are no protections."""
        return "none"

    def start(
        self,
        limits: Limits,
        forbidden: Iterable[str] = (),
        packages: Iterable[str] = (),
        named_packages: Iterable[str] = (),
    ) -> Worker:
        """Start a worker; see `grader.sandbox.protocol.Sandbox`."""
        rules = {"user": None, "limits": limits.resources(), "forbidden": list(forbidden)}
        return launch((), os.environ.get("HOME", "/tmp"), rules, limits)
