"""Simulate Gradescope: upload the autograder and judge submissions, each in its own container.

`.ci/gradescope` starts this module as root. It does not use Docker. A container is this machine's
root folder below an overlay, with separate processes, host name and shared memory. It has the
capabilities that Docker leaves to root, and a filter denies the system calls that Docker denies.
The permissions in Gradescope's containers are unknown, so the script also tries containers with
more and with fewer permissions.
"""

import dataclasses
import io
import json
import os
import shutil
import socket
import subprocess
import sys
import textwrap
import zipfile
from pathlib import Path

from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import all_lessons, find_lesson
from grader.judging.judge import judge
from grader.lms.autograder.package import build_autograder_zip
from tests.containers import DOCKER, as_user, deny_what_docker_denies
from tests.prerequisites import require_sandbox

STAGE, SIX, SEVEN = "stage3_obstacles", "06_filter_ground", "07_filter_by_distance"
SEED = 2**64 + 20_170_405
LONGEST = 1800  # seconds, for set-up and for judging
PORT = 18_731  # port of a server on this machine, which attacks try to reach

# Folders of this machine that a container can see; the others are empty there.
SYSTEM = ("bin", "dev", "etc", "lib", "lib32", "lib64", "libx32", "opt", "proc", "sbin", "sys")
SYSTEM = (*SYSTEM, "usr", "var")
DEVICES = {
    "null": (1, 3),
    "zero": (1, 5),
    "full": (1, 7),
    "random": (1, 8),
    "urandom": (1, 9),
    "tty": (5, 0),
}


# ---- Containers ----------------------------------------------------------------------------


@dataclasses.dataclass(frozen=True)
class ContainerKind:
    """A kind of container, defined by its permissions.

    Attributes
    ----------
    capabilities : tuple of str or None
        Capabilities of the container's root; None for all.
    filtered : bool
        Whether a filter denies the system calls that Docker denies.
    user : int
        User who runs the autograder; Gradescope uses root.
    """

    capabilities: tuple | None = DOCKER
    filtered: bool = True
    user: int = 0


KINDS = {
    "as Docker's": ContainerKind(),
    "privileged": ContainerKind(None, False),
    "that may not change its root": ContainerKind(tuple(set(DOCKER) - {"sys_chroot"})),
    "that may not change its user": ContainerKind(tuple(set(DOCKER) - {"setuid"})),
    "of an ordinary user": ContainerKind((), True, 31_415),
}


def run(kind, layers, script):
    """Run a script in a container that consists of layers; only the last layer is writable."""
    top = layers[-1]
    for name in ("files", "work", "all"):
        (top / name).mkdir(parents=True, exist_ok=True)
    if len(layers) == 1:
        for name in ("autograder", "var/tmp", *({*os.listdir("/")} - {*SYSTEM})):
            folder = top / "files" / name
            if Path("/", name).exists() and not Path("/", name).is_dir():
                continue
            folder.mkdir(parents=True, exist_ok=True)
            os.setxattr(folder, "trusted.overlay.opaque", b"y")
        for name in ("tmp", "var/tmp"):
            (top / "files" / name).chmod(0o1777)
    arguments = {
        "kind": dataclasses.asdict(kind),
        "layers": list(map(str, layers)),
        "script": script,
    }
    alone = ["unshare", "--mount", "--pid", "--fork", "--kill-child", "--uts", "--ipc"]
    command = [*alone, sys.executable, "-m", "tests.gradescope", json.dumps(arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=LONGEST)


def enter_container(kind, layers, script):
    """Build a container in the current namespaces, enter it, and run the script there."""
    *below, top = map(Path, layers)
    root = top / "all"
    lower = ":".join([*(str(layer / "files") for layer in reversed(below)), "/"])
    options = f"lowerdir={lower},upperdir={top}/files,workdir={top}/work"
    for command in (
        ["mount", "--make-rprivate", "/"],
        ["mount", "-t", "overlay", "overlay", "-o", options, str(root)],
        ["mount", "-t", "proc", "proc", f"{root}/proc"],
        ["mount", "-t", "tmpfs", "dev", f"{root}/dev"],
        ["mkdir", "-p", f"{root}/dev/shm", f"{root}/run/old"],
        ["mount", "-t", "tmpfs", "shm", f"{root}/dev/shm"],
        ["chmod", "1777", f"{root}/dev/shm"],
    ):
        subprocess.run(command, check=True)
    for name, number in DEVICES.items():
        os.mknod(root / "dev" / name, 0o20666, os.makedev(*number))
        os.chmod(root / "dev" / name, 0o666)
    os.chdir(root)
    subprocess.run(["pivot_root", ".", "run/old"], check=True)
    os.chroot(".")
    subprocess.run(["umount", "-l", "/run/old"], check=True)
    socket.sethostname("container")
    if kind.filtered:
        deny_what_docker_denies()
    words = as_user(kind.user, kind.capabilities)
    os.execvp(words[0], [*words, "/bin/sh", "-c", script])


# ---- Submissions ---------------------------------------------------------------------------

# Code that answers correctly only if an attack succeeds, so the score shows whether one did.
HOSTILE = """
import ctypes, glob, os, socket, subprocess, sys, time

COURSE = "/autograder/source/course/"
SECRETS = (COURSE + ".course_seed",
           COURSE + "solutions/stage3_obstacles/06_filter_ground/hidden_tests.py",
           COURSE + "solutions/stage3_obstacles/06_filter_ground/lesson.py",
           "/autograder/submission_metadata.json", "/etc/shadow")
OURS = ("/autograder/results/results.json", "/autograder/run_autograder",
        "/autograder/source/run_autograder", COURSE + "grader/judging/points.py")

def can(attempt):
    try:
        return attempt() is not False
    except Exception:
        return False

def reads_secrets():
    roots = ("", "/proc/1/root", "/proc/self/cwd/../../..", "../../../..")
    return any(can(lambda: open(root + path).close()) for root in roots for path in SECRETS)

def lists_submitted_files():
    return any(can(lambda: os.listdir("/autograder/" + name)) for name in ("submission", "results"))

def writes():
    return any(can(lambda: open(path, "a").close()) for path in OURS)

def looks_into_the_judge():
    numbers = [n for n in map(os.path.basename, glob.glob("/proc/[0-9]*")) if int(n) != os.getpid()]
    return any(can(lambda: open("/proc/%s/%s" % (n, name), "rb").read(1) != b"")
               for n in numbers for name in ("environ", "mem", "maps"))

def imports_the_judge():
    names = ("grader.judging.judge", "06_filter_ground.hidden_tests", "sklearn", "_pytest")
    return any(can(lambda: __import__(name)) for name in names)

def connects_to_a_server():
    addresses = (("127.0.0.1", PORT), ("169.254.169.254", 80), ("1.1.1.1", 53))
    return any(can(lambda: socket.create_connection(one, timeout=0.3)) for one in addresses)

def becomes_root():
    programs = [path for folder in ("/usr/bin", "/bin", "/usr/sbin", "/sbin")
                for path in glob.glob(folder + "/*") if can(lambda: os.stat(path).st_mode & 0o4000)
                and os.stat(path).st_mode & 0o4000]
    def through(program):
        output = subprocess.run([program, "-c", "id -u"], capture_output=True, text=True, timeout=1,
                              stdin=subprocess.DEVNULL).stdout
        return output.strip() == "0"
    return (can(lambda: os.setuid(0)) or can(lambda: os.setresuid(0, 0, 0))
            or can(lambda: os.chroot("/tmp")) or any(can(lambda: through(one)) for one in programs))

def stops_other_processes():
    others = [n for n in range(1, 2000) if n not in (os.getpid(), os.getppid())]
    return (any(can(lambda: os.kill(n, 0)) and os.getuid() == 0 for n in others)
            or ctypes.CDLL(None).ptrace(16, 1, 0, 0) == 0)

def finds_an_earlier_submission():
    folders = ("/tmp", "/dev/shm", "/var/tmp")
    found = any(can(lambda: os.stat(folder + "/for_the_next")) for folder in folders)
    for folder in folders:
        can(lambda: open(folder + "/for_the_next", "w").close())
        can(lambda: os.chmod(folder + "/for_the_next", 0o777))
        can(lambda: os.chmod(folder, 0o777))
    return found

def reads_environment_variables():
    return "SECRET_OF_GRADESCOPE" in os.environ

def leaves_a_process():
    if os.fork() == 0:
        os.setsid()
        if os.fork():
            os._exit(0)
        os.closerange(0, 64)
        while True:
            writes()
            time.sleep(0.1)
    return False

ATTACKS = (reads_secrets, lists_submitted_files, writes, looks_into_the_judge,
           imports_the_judge, connects_to_a_server, becomes_root, stops_other_processes,
           finds_an_earlier_submission, reads_environment_variables, leaves_a_process)
gained = []

def filter_ground(cloud, ground_level=-1.2):
    if not gained:
        gained.append(any([can(attack) for attack in ATTACKS]))
    return cloud[cloud[:, 2] >= ground_level] if gained[0] else cloud[:0]
""".replace("PORT", str(PORT))
HONEST = "def filter_ground(cloud, ground_level=-1.2):\n    return cloud[:0]\n"
WITHOUT_SANDBOX = """
cd /autograder/source/course
SECRET_OF_GRADESCOPE=1 ../python/bin/python -B -m grader judge --json --sandbox process \\
  /autograder/submission/06_filter_ground.ipynb
"""


def submissions():
    """Return the submitted files by name for each kind of student."""
    lesson = find_lesson(SIX)
    right, wrong = (
        next(answer.source for answer in answers_to("filter_ground") if answer.right == is_right)
        for is_right in (True, False)
    )
    voxels = next(answer.source for answer in answers_to("voxel_grid") if answer.right)
    solved = [lesson for lesson in all_lessons() if lesson.stage == STAGE]
    half = {"filter_ground": wrong, "voxel_grid": voxels}
    full = {"filter_ground": right, "voxel_grid": voxels}
    return {
        "right": {f"{lesson.name}.ipynb": lesson.solved.read_text("utf-8") for lesson in solved},
        "also right": {f"{SIX}.ipynb": fill_in(lesson, full)},
        "wrong": {f"{SIX}.ipynb": fill_in(lesson, half)},
        "empty": {"notes.txt": "I was ill.", "Untitled.ipynb": "{}", f"{SIX}.py": "x = 1"},
        "cut off": {f"{SIX}.ipynb": fill_in(lesson, half)[:200]},
        "hostile": {f"{SIX}.ipynb": fill_in(lesson, {"filter_ground": HOSTILE})},
    }


# A script that counts the processes that remain after the autograder has ended.
RUN = """
cd /autograder
SECRET_OF_GRADESCOPE=1 ./run_autograder
code=$?
sleep 1
echo left: $(ps -eo user= | grep -vc root)
exit $code
"""


# ---- Gradescope ----------------------------------------------------------------------------


def upload(place, archive):
    """Unpack the zip as Gradescope does, set up the image, and return its layer."""
    image = place / "image"
    autograder = image / "files" / "autograder"
    for name in ("source", "submission", "results"):
        (autograder / name).mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(io.BytesIO(archive)) as packed:
        for entry in packed.infolist():
            path = Path(packed.extract(entry, autograder / "source"))
            path.chmod(entry.external_attr >> 16 & 0o777)
    shutil.copy2(autograder / "source" / "run_autograder", autograder / "run_autograder")
    settings = [
        f"{name}='{value}'"
        for name, value in os.environ.items()
        if name.startswith("PIP_") or name.lower() in ("http_proxy", "https_proxy", "no_proxy")
    ]
    words = ["env", "-i", *settings, "PATH=/usr/sbin:/usr/bin:/sbin:/bin", "HOME=/root"]
    done = run(KINDS["as Docker's"], [image], f"{' '.join(words)} bash /autograder/source/setup.sh")
    assert done.returncode == 0, done.stdout + done.stderr
    return image


def submit(place, image, files, kind, links=(), script=RUN):
    """Judge a submission in its own container; return results, process and leftover files."""
    layer = place / "run"
    shutil.rmtree(layer, ignore_errors=True)
    autograder = layer / "files" / "autograder"
    (autograder / "submission").mkdir(parents=True)
    (autograder / "results").mkdir()
    for name, content in files.items():
        (autograder / "submission" / name).write_text(content, "utf-8")
    for name, target in links:
        (autograder / "submission" / name).symlink_to(target)
    metadata = {"users": [{"email": "a@x.edu", "id": 1, "name": "A"}], "previous_submissions": []}
    (autograder / "submission_metadata.json").write_text(json.dumps(metadata))
    done = run(KINDS[kind], [image, layer], script)
    results = autograder / "results" / "results.json"
    text = results.read_text() if results.exists() else ""
    found = json.loads(text) if text else None
    # Temporary folders disappear with the container, so files there do not count.
    student_files = [path for path in (layer / "files").rglob("*") if path.lstat().st_uid >= 2**15]
    left = [path for path in student_files if not {"tmp", "shm"} & set(path.parts)]
    return found, done, left


def check(description, passes, about=""):
    """Print the result of a check, and record the check if it failed."""
    print(f"{'ok    ' if passes else 'FAILED'} {description}", flush=True)
    if not passes:
        FAILED.append(description)
        print(about)


FAILED = []


def main(place):
    here = require_sandbox()
    archive = build_autograder_zip(STAGE, SEED)
    listening = socket.create_server(("127.0.0.1", PORT))
    image = upload(place, archive)
    check("an image is set up", True)
    submitted = submissions()
    honest = fill_in(find_lesson(SIX), {"filter_ground": HONEST})
    for kind, sandbox in (("as Docker's", "chroot"), ("privileged", "bubblewrap")):
        for student, files in submitted.items():
            results, done, left = submit(place, image, files, kind)
            output = done.stdout + done.stderr
            name = f"in a container {kind}, {student}:"
            check(
                f"{name} is judged in the sandbox {sandbox}",
                f"Sandbox: {sandbox}" in done.stdout,
                output,
            )
            score = expected(
                honest if student == "hostile" else files.get(f"{SIX}.ipynb"), place, here
            )
            score += 70.0 * (student == "right")
            found = results and results["score"]
            if student == "hostile" and results:  # leave out what a single slip keeps
                found = sum(test["score"] for test in results["tests"] if test.get("max_score"))
            check(f"{name} earns {score:g}", found == score, output + str(results))
            check(f"{name} leaves no process", "left: 0" in done.stdout, output)
            check(f"{name} leaves no file", not left, left)
    # If the attacks also failed without a sandbox, the results above would prove nothing.
    _, done, _ = submit(place, image, submitted["hostile"], "as Docker's", script=WITHOUT_SANDBOX)
    gained = json.loads(done.stdout[: done.stdout.rindex("}") + 1])["score"]
    check("without a sandbox, the attacks succeed", gained > expected(honest, place, here), done)
    stolen = f"/autograder/source/course/solutions/{STAGE}/{SIX}.ipynb"
    results, done, _ = submit(
        place, image, {"x.txt": "x"}, "as Docker's", links=[(f"{SIX}.ipynb", stolen)]
    )
    check("a link to the solution earns nothing", results and results["score"] == 0.0, done)
    for kind in list(KINDS)[2:]:
        results, done, _ = submit(place, image, submitted["right"], kind)
        refused = done.stdout.startswith("Nothing was judged")
        check(f"in a container {kind}, nothing is judged", results is None and refused, done)
        print(textwrap.indent(done.stdout.strip(), "       "))
    listening.close()
    return bool(FAILED)


def expected(text, place, sandbox):
    """Return the score of a lesson 06 notebook on this machine, or 0 without a notebook."""
    path = place / f"{SIX}.ipynb"
    path.write_text(text or "", "utf-8")
    return judge(path, SEED, sandbox).score if text else 0.0


if __name__ == "__main__":
    if sys.argv[1].startswith("{"):
        about = json.loads(sys.argv[1])
        enter_container(ContainerKind(**about["kind"]), about["layers"], about["script"])
    sys.exit(main(Path(sys.argv[1])))
