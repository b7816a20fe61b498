"""Judge on the workers of a Dask cluster.

Workers need Python, the packages of requirements-cluster.txt and, on processors other than x86-64,
the system's bubblewrap. A plugin sends the course's code to each worker once. Jobs and results
travel as bytes, so neither the scheduler nor a worker needs a module of this project.
"""

from __future__ import annotations

import functools
import logging
import pickle
import threading
import time
import uuid
import warnings
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Executor, Future

import cloudpickle
import dask
import distributed

from grader.classroom import worker_plugin
from grader.classroom.protocol import ROOM, ExecutorLost
from grader.course.archives import zipped
from grader.course.portable_files import files_to_judge_with
from grader.judging.key import versions

PATIENCE = 15 * 60
"""Seconds without any worker that can judge, after which grading stops."""
CHECK = 1.0
"""Seconds from one look at the scheduler to the next."""
CONNECT = 30
"""Seconds that a scheduler may take to answer."""

cloudpickle.register_pickle_by_value(worker_plugin)


class _ByValue:
    """A function that is pickled by value, with its code."""

    def __init__(self, function: Callable) -> None:
        self._code = cloudpickle.dumps(function)

    def __call__(self) -> None:
        raise TypeError("It is a function only where it arrives.")

    def __reduce__(self) -> tuple:
        return cloudpickle.loads, (self._code,)


def connect(address: str, sandbox: str, tell: Callable[[str], None]) -> Executor:
    """Join a cluster.

    The address says whether the connection is encrypted (``tls://``); the certificates are in
    Dask's own configuration.

    Parameters
    ----------
    address : str
        Address of the scheduler.
    sandbox : str
        A name in `grader.sandbox.SANDBOXES`, which workers must have.
    tell : callable
        Called with sentences for the instructor, such as on a worker that was refused.

    Raises
    ------
    grader.classroom.protocol.ExecutorLost
        If no scheduler answers, or there are no certificates for it.
    """
    # Problems are reported in sentences below, and other versions only if they matter.
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    warnings.simplefilter("ignore", distributed.versions.VersionMismatchWarning)
    # A client that fails for this reason would hang when Python ends.
    if address.startswith("tls:") and not distributed.Security().tls_client_cert:
        raise ExecutorLost(
            f"{address} asks for certificates, and Dask's configuration here names none. Name "
            "them under distributed.comm.tls, as grader/README.md shows."
        )
    try:
        client = _client(address)
    except (OSError, ValueError, TypeError) as error:
        raise ExecutorLost(
            f"No scheduler answers at {address} ({error}). Start one with: dask scheduler\n"
            "and a worker or more with: dask worker ADDRESS\n"
            "What has been judged is kept: the same command goes on from there."
        ) from None
    return Cluster(client, address, sandbox, tell)


def _client(address: str) -> distributed.Client:
    try:
        return distributed.Client(address, timeout=CONNECT, set_as_default=False)
    except AssertionError:  # Dask's own thread got no processor for ten seconds
        return distributed.Client(address, timeout=CONNECT, set_as_default=False)


def packed_course() -> bytes:
    """Return the files that judging reads as a zip file; the same files give the same bytes."""
    return zipped(files_to_judge_with())


class Cluster(Executor):
    """The fit workers of a cluster, as one executor.

    Parameters
    ----------
    client : distributed.Client
    address, sandbox, tell
        As in `connect`.
    """

    def __init__(
        self, client: distributed.Client, address: str, sandbox: str, tell: Callable[[str], None]
    ) -> None:
        self._client, self._address, self._tell = client, address, tell
        self._name = f"lidar-obstacle-lab-{uuid.uuid4().hex}"
        self._fit: dict[str, int] = {}
        self._refused: dict[str, str] = {}
        self._waiting: dict[Future, distributed.Future] = {}
        self._lost: ExecutorLost | None = None
        self._lock, self._over = threading.Lock(), threading.Event()
        self._judge = _ByValue(worker_plugin.judge_on_worker)
        client.subscribe_topic(self._name, self._record_event)
        plugin = worker_plugin.JudgePlugin(self._name, packed_course(), versions(), sandbox)
        for work in (functools.partial(self._send, plugin), self._watch):
            threading.Thread(target=work, daemon=True).start()

    def __exit__(self, kind: type | None, *about: object) -> None:
        self.shutdown(cancel_futures=kind is not None)

    @property
    def room(self) -> int:
        """Room for one notebook per thread, and one more that waits."""
        return max(ROOM, 3 * sum(self._fit.values()))

    def submit(self, function: Callable, /, *arguments: object) -> Future:
        """Schedule a call on a fit worker, as soon as there is one."""
        answer = Future()
        job = pickle.dumps((function, arguments))
        with self._lock:
            if self._lost:
                raise self._lost
            with dask.config.set({"distributed.admin.large-graph-warning-threshold": "1GB"}):
                there = self._client.submit(
                    self._judge,
                    self._name,
                    job,
                    key=f"judge-{uuid.uuid4().hex}",
                    pure=False,
                    resources={self._name: 1},
                )
            self._waiting[answer] = there
        there.add_done_callback(functools.partial(self._deliver, answer))
        return answer

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Leave the cluster unchanged; see `concurrent.futures.Executor.shutdown`."""
        if self._over.is_set():
            return
        if wait and not cancel_futures:
            for answer in list(self._waiting):
                answer.exception()
        self._over.set()
        for answer in list(self._waiting):
            answer.cancel()
        if not self._lost:
            _call_quietly(self._client.unregister_worker_plugin, self._name)
        _call_quietly(self._client.close, timeout=5)

    def _send(self, plugin: worker_plugin.JudgePlugin) -> None:
        """Send the plugin to every worker, including those that join later."""
        # Each worker reports the result itself: one that hangs must not delay the others.
        _call_quietly(self._client.register_plugin, plugin, name=self._name)

    def _record_event(self, event: tuple[float, dict]) -> None:
        """Record what a worker reports about itself."""
        said = event[1]
        if not said["complaint"]:
            self._fit[said["worker"]] = said["threads"]
            return
        self._refused[said["worker"]] = said["complaint"]
        self._tell(
            f"Worker {said['worker']} on {said['machine']} judges nothing; its notebooks go "
            f"elsewhere. {said['complaint']}"
        )

    def _deliver(self, answer: Future, there: distributed.Future) -> None:
        """Pass on the result of a job."""
        try:
            if there.status == "finished":
                good, value = pickle.loads(there.result())
            elif there.status == "error":
                good, value = False, there.exception()
            else:
                raise ConnectionError
        except Exception:
            if not self._over.is_set():
                self._give_up(self._silence())
            return
        if isinstance(value, distributed.scheduler.KilledWorker):
            # As often as Dask tries, the whole worker died.
            value = BrokenExecutor(str(value))
        with self._lock:
            if self._waiting.pop(answer, None) and answer.set_running_or_notify_cancel():
                answer.set_result(value) if good else answer.set_exception(value)

    def _watch(self) -> None:
        """Stop waiting when no worker is left."""
        last, told = time.monotonic(), False
        while not self._over.wait(CHECK):
            try:
                present = set(self._client.nthreads())
            except Exception:
                self._give_up(self._silence())
                return
            now = time.monotonic()
            for address in set(self._fit) - present:
                self._fit.pop(address, None)
            if self._fit:
                last, told = now, False
            elif present and present <= set(self._refused):
                self._give_up(
                    f"No worker of {self._address} can judge, for the reasons above. Mend one, or "
                    "start another, and give the same command again. What has been judged is kept."
                )
                return
            elif now - last > PATIENCE:
                self._give_up(
                    f"For {PATIENCE / 60:.0f} minutes {self._address} has had no worker that can "
                    f"judge. Start some with: dask worker {self._address}\nand give the same "
                    "command again. What has been judged is kept."
                )
                return
            elif now - last > 10 and not told:
                told = True
                self._tell(
                    f"{self._address} has no worker that can judge yet. Waiting for one, for "
                    f"{PATIENCE / 60:.0f} minutes: dask worker {self._address}"
                )

    def _give_up(self, reason: str) -> None:
        with self._lock:
            self._lost = ExecutorLost(reason)
            waiting = list(self._waiting)
            self._waiting.clear()
        for answer in waiting:
            if answer.set_running_or_notify_cancel():
                answer.set_exception(self._lost)

    def _silence(self) -> str:
        return (
            f"The scheduler {self._address} does not answer any more. What has been judged is "
            "kept: start it and its workers again, and give the same command."
        )


def _call_quietly(function: Callable, *arguments: object, **options: object) -> None:
    """Call a function and ignore a failure, which is detected elsewhere or does not matter."""
    try:
        function(*arguments, **options)
    except Exception as error:
        logging.getLogger(__name__).info("%s: %r", function, error)
