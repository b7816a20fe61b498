"""Judge on the workers of a Dask cluster.

Workers need Python, the packages in requirements-cluster.txt and, on processors other than x86-64,
the system's bubblewrap. A plugin sends the course's code to each worker once. Jobs and results are
sent as bytes, so neither the scheduler nor the workers need this project installed.
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
from grader.classroom.protocol import DEFAULT_CAPACITY, ExecutorLost
from grader.course.archives import make_zip
from grader.course.portable_files import files_for_judging
from grader.judging.verdict_key import versions

MAX_WAIT_SECONDS = 15 * 60
"""Seconds without a suitable worker after which grading stops."""
POLLING_INTERVAL = 1.0
"""Seconds between two queries to the scheduler."""
CONNECTION_TIMEOUT = 30
"""Seconds that a scheduler may take to answer."""

cloudpickle.register_pickle_by_value(worker_plugin)


class _FunctionByValue:
    """A function that is pickled with its code, so workers need not have its module."""

    def __init__(self, function: Callable) -> None:
        self._code = cloudpickle.dumps(function)

    def __call__(self) -> None:
        raise TypeError("Unpickle this object to get the function.")

    def __reduce__(self) -> tuple:
        return cloudpickle.loads, (self._code,)


def connect(address: str, sandbox: str, notify: Callable[[str], None]) -> Executor:
    """Connect to a cluster.

    A ``tls://`` address uses an encrypted connection with the certificates in Dask's configuration.

    Parameters
    ----------
    address : str
        Address of the scheduler.
    sandbox : str
        Name of a sandbox in `grader.sandbox.SANDBOXES` that workers must have.
    notify : callable
        Called with messages for the instructor, for example when a worker is refused.

    Raises
    ------
    grader.classroom.protocol.ExecutorLost
        If no scheduler answers, or if certificates are required and none are configured.
    """
    # Silence Dask: problems are reported below, and version differences only if they matter.
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    warnings.simplefilter("ignore", distributed.versions.VersionMismatchWarning)
    # A client that fails because it has no certificates hangs when Python exits.
    if address.startswith("tls:") and not distributed.Security().tls_client_cert:
        raise ExecutorLost(
            f"{address} requires certificates, but this machine's Dask configuration contains "
            "none. Add them under distributed.comm.tls, as in docs/platforms/cluster.md."
        )
    try:
        client = _client(address)
    except (OSError, ValueError, TypeError) as error:
        raise ExecutorLost(
            f"No scheduler responded at {address} ({error}). Start one with: dask "
            "scheduler\nand one or more workers with: dask worker ADDRESS\nVerdicts are "
            "kept. Run the same command again to continue."
        ) from None
    return Cluster(client, address, sandbox, notify)


def _client(address: str) -> distributed.Client:
    try:
        return distributed.Client(address, timeout=CONNECTION_TIMEOUT, set_as_default=False)
    except AssertionError:  # Dask's own thread got no CPU time for ten seconds
        return distributed.Client(address, timeout=CONNECTION_TIMEOUT, set_as_default=False)


def packed_course() -> bytes:
    """Return a reproducible zip of the files that judging needs."""
    return make_zip(files_for_judging())


class Cluster(Executor):
    """An executor that runs jobs on the suitable workers of a cluster.

    Parameters
    ----------
    client : distributed.Client
    address, sandbox, notify
        As in `connect`.
    """

    def __init__(
        self, client: distributed.Client, address: str, sandbox: str, notify: Callable[[str], None]
    ) -> None:
        self._client, self._address, self._notify = client, address, notify
        self._name = f"lidar-obstacle-lab-{uuid.uuid4().hex}"
        self._suitable_workers: dict[str, int] = {}
        self._refused_workers: dict[str, str] = {}
        self._waiting: dict[Future, distributed.Future] = {}
        self._failure: ExecutorLost | None = None
        self._lock, self._closed = threading.Lock(), threading.Event()
        self._judge = _FunctionByValue(worker_plugin.judge_on_worker)
        client.subscribe_topic(self._name, self._record_event)
        plugin = worker_plugin.JudgePlugin(self._name, packed_course(), versions(), sandbox)
        for task in (functools.partial(self._send, plugin), self._watch):
            threading.Thread(target=task, daemon=True).start()

    def __exit__(self, kind: type | None, *details: object) -> None:
        self.shutdown(cancel_futures=kind is not None)

    @property
    def capacity(self) -> int:
        """Number of notebooks to send at a time: three per thread, so that no thread waits."""
        return max(DEFAULT_CAPACITY, 3 * sum(self._suitable_workers.values()))

    def submit(self, function: Callable, /, *arguments: object) -> Future:
        """Schedule a call, which runs as soon as a suitable worker is free."""
        future = Future()
        job = pickle.dumps((function, arguments))
        with self._lock:
            if self._failure:
                raise self._failure
            with dask.config.set({"distributed.admin.large-graph-warning-threshold": "1GB"}):
                remote_future = self._client.submit(
                    self._judge,
                    self._name,
                    job,
                    key=f"judge-{uuid.uuid4().hex}",
                    pure=False,
                    resources={self._name: 1},
                )
            self._waiting[future] = remote_future
        remote_future.add_done_callback(functools.partial(self._deliver, future))
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Disconnect and leave the cluster running; see `concurrent.futures.Executor.shutdown`."""
        if self._closed.is_set():
            return
        if wait and not cancel_futures:
            for future in list(self._waiting):
                future.exception()
        self._closed.set()
        for future in list(self._waiting):
            future.cancel()
        if not self._failure:
            _call_quietly(self._client.unregister_worker_plugin, self._name)
        _call_quietly(self._client.close, timeout=5)

    def _send(self, plugin: worker_plugin.JudgePlugin) -> None:
        """Send the plugin to every worker, including those that join later."""
        # Each worker reports separately, so a worker that hangs does not delay the others.
        _call_quietly(self._client.register_plugin, plugin, name=self._name)

    def _record_event(self, event: tuple[float, dict]) -> None:
        """Record a worker's report about itself."""
        report = event[1]
        if not report["complaint"]:
            self._suitable_workers[report["worker"]] = report["threads"]
            return
        self._refused_workers[report["worker"]] = report["complaint"]
        self._notify(
            f"Worker {report['worker']} on {report['machine']} gets no notebooks. "
            f"{report['complaint']}"
        )

    def _deliver(self, future: Future, remote_future: distributed.Future) -> None:
        """Set a job's result or error on its future."""
        try:
            if remote_future.status == "finished":
                succeeded, value = pickle.loads(remote_future.result())
            elif remote_future.status == "error":
                succeeded, value = False, remote_future.exception()
            else:
                raise ConnectionError
        except Exception:
            if not self._closed.is_set():
                self._give_up(self._unreachable_message())
            return
        if isinstance(value, distributed.scheduler.KilledWorker):
            # The worker process died in each of Dask's attempts.
            value = BrokenExecutor(str(value))
        with self._lock:
            if self._waiting.pop(future, None) and future.set_running_or_notify_cancel():
                future.set_result(value) if succeeded else future.set_exception(value)

    def _watch(self) -> None:
        """Watch the workers, and give up when none of them can judge."""
        last_suitable, is_announced = time.monotonic(), False
        while not self._closed.wait(POLLING_INTERVAL):
            try:
                present = set(self._client.nthreads())
            except Exception:
                self._give_up(self._unreachable_message())
                return
            now = time.monotonic()
            for address in set(self._suitable_workers) - present:
                self._suitable_workers.pop(address, None)
            if self._suitable_workers:
                last_suitable, is_announced = now, False
            elif present and present <= set(self._refused_workers):
                self._give_up(
                    f"No worker at {self._address} can judge, for the reasons above. Fix a worker "
                    "or start another, and run the same command again. Verdicts are kept."
                )
                return
            elif now - last_suitable > MAX_WAIT_SECONDS:
                self._give_up(
                    f"The scheduler {self._address} has had no suitable worker for "
                    f"{MAX_WAIT_SECONDS / 60:.0f} minutes. Start one with: dask worker "
                    f"{self._address}\nand run the same command again. Verdicts are kept."
                )
                return
            elif now - last_suitable > 10 and not is_announced:
                is_announced = True
                self._notify(
                    f"The scheduler {self._address} has no suitable worker yet. Start one "
                    f"within {MAX_WAIT_SECONDS / 60:.0f} minutes: dask worker {self._address}"
                )

    def _give_up(self, reason: str) -> None:
        with self._lock:
            self._failure = ExecutorLost(reason)
            waiting = list(self._waiting)
            self._waiting.clear()
        for future in waiting:
            if future.set_running_or_notify_cancel():
                future.set_exception(self._failure)

    def _unreachable_message(self) -> str:
        return (
            f"The scheduler {self._address} no longer answers. Verdicts are kept. "
            "Start it and its workers, and run the same command again."
        )


def _call_quietly(function: Callable, *arguments: object, **options: object) -> None:
    """Call a function and ignore errors, because they are reported elsewhere or do not matter."""
    try:
        function(*arguments, **options)
    except Exception as error:
        logging.getLogger(__name__).info("%s: %r", function, error)
