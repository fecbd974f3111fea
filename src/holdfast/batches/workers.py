"""Answer jobs by worker processes: several on this machine, or one for each task of a Dask scheduler's workers."""

from __future__ import annotations

import atexit
import threading
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from itertools import islice
from multiprocessing.connection import wait
from typing import TYPE_CHECKING

from holdfast import __version__
from holdfast.base.borders.supervisor import Limits, Reply, Supervisor
from holdfast.base.errors import HoldfastError, installing, message
from holdfast.base.text import quoted
from holdfast.batches.job import BatchQuestion, Job

if TYPE_CHECKING:
    from distributed import Client, Future


ANSWERED_BY = "holdfast.batches.rows:answered"
AHEAD = 2  # number of submitted tasks per thread of the cluster, which bounds the memory of replies
SECONDS = 30  # [s] timeout of the connection to the scheduler

_own = threading.local()  # holds the supervisor of each thread of a Dask worker
_lock = threading.Lock()
_supervisors: list[Supervisor] = []


def supervisor_for(question: BatchQuestion, limits: Limits) -> Supervisor:
    """Return the supervisor of a worker that answers this question."""
    return Supervisor(ANSWERED_BY, Job(0, "", question.bare), limits)


def answered_here(
    jobs: Iterator[Job], question: BatchQuestion, limits: Limits, workers: int
) -> Iterator[tuple[Job, Reply]]:
    """Yield every job with its reply.

    One job more than there are workers is drawn in advance. It is given to the first idle worker before that worker's
    reply is yielded, so that no worker waits for jobs or for the consumer of replies.
    """
    with ExitStack() as stack:
        idle = [stack.enter_context(supervisor_for(question, limits)) for _ in range(workers)]
        busy: list[Supervisor] = []
        waiting: Job | None = None

        def give() -> None:
            nonlocal waiting
            if idle and waiting is not None:
                idle[-1].give(waiting)
                busy.append(idle.pop())
                waiting = None

        while True:
            while waiting is None and (waiting := next(jobs, None)) is not None:
                give()
            if not busy:
                return
            wait([supervisor.answers for supervisor in busy], min(supervisor.left for supervisor in busy))
            for supervisor in list(busy):
                reply = supervisor.take()
                if reply is not None:
                    job = supervisor.item
                    busy.remove(supervisor)
                    idle.append(supervisor)
                    give()
                    yield job, reply


def answered_there(
    jobs: Iterator[Job], question: BatchQuestion, limits: Limits, scheduler: str | Client
) -> Iterator[tuple[Job, Reply]]:
    """Yield every job with its reply from the workers of a Dask scheduler.

    If a Dask worker is lost, Dask gives its job to another one. Raises HoldfastError if the scheduler cannot be
    reached, or if a worker has another version of holdfast.
    """
    try:
        from distributed import Client, as_completed
    except ImportError as cause:
        problem = "needs distributed, which is not installed"
        raise HoldfastError(message("scheduler", problem, installing("cluster"))) from cause
    with ExitStack() as stack:
        client = scheduler
        if not isinstance(client, Client):
            client = stack.enter_context(connected(scheduler))
        given: dict[Future, Job] = {}
        done = as_completed(loop=client.loop)  # without a loop it uses Dask's default client, which ours is not
        stack.callback(lambda: client.cancel(list(given)))
        for job in islice(jobs, _room(client)):
            given[_submitted(client, job, question, limits)] = job
        done.update(given)
        for future in done:
            job = given.pop(future)
            version, reply = _result(future)
            if version != __version__:
                problem = f"a worker has holdfast {version}, and this is {__version__}"
                raise HoldfastError(message("scheduler", problem, "install the same version everywhere"))
            yield job, reply
            for more in islice(jobs, max(_room(client) - len(given), 1)):
                future = _submitted(client, more, question, limits)
                given[future] = more
                done.add(future)


def asked(job: Job, question: BatchQuestion, limits: Limits) -> tuple[str, Reply]:
    """Answer a job in this thread's own worker process; return the version of holdfast there, and the reply."""
    own = getattr(_own, "supervisor", None)
    if own is None or own not in _supervisors or _own.about != (question.text, limits):
        with _lock:
            if own in _supervisors:
                _supervisors.remove(own)
                own.close()
            _own.supervisor, _own.about = supervisor_for(question, limits), (question.text, limits)
            _supervisors.append(_own.supervisor)
    return __version__, _own.supervisor.ask(job)


@atexit.register
def close_supervisors() -> None:
    """End the worker processes of all tasks in this process."""
    with _lock:
        while _supervisors:
            _supervisors.pop().close()


def connected(address: object, files: Mapping[str, str] | None = None) -> Client:
    """Return a client of the scheduler at ``address``.

    ``files`` maps arguments of Dask's Security to the paths of certificates. Raises HoldfastError if the scheduler
    cannot be reached.
    """
    from distributed import Client, Security

    if not isinstance(address, str):
        remedy = "needs an address such as 'tcp://host:8786', or a distributed.Client"
        raise HoldfastError(message("scheduler", f"got {quoted(address)}", remedy))
    try:
        security = Security(require_encryption=True, **files) if files else None
        return Client(address, timeout=SECONDS, set_as_default=False, security=security)
    except (OSError, ValueError, TypeError) as cause:
        remedy = "check the address, and for tls:// the certificates"
        raise HoldfastError(message("scheduler", f"{quoted(address)} cannot be reached: {cause}", remedy)) from cause


def _room(client: Client) -> int:
    """Return how many tasks may be submitted at a time."""
    threads: int = sum(client.nthreads().values())
    return max(AHEAD * threads, 1)


def _submitted(client: Client, job: Job, question: BatchQuestion, limits: Limits) -> Future:
    return client.submit(asked, job, question.bare, limits, pure=False, key=f"holdfast-{job.number}-{id(job)}")


def _result(future: Future) -> tuple[str, Reply]:
    try:
        version, reply = future.result()
    except HoldfastError:
        raise
    except Exception as cause:  # from Dask: a worker without holdfast, or a task whose workers were lost too often
        problem = f"a task failed: {type(cause).__name__}: {cause}"
        raise HoldfastError(message("scheduler", problem, "check the workers, and ask again")) from cause
    return version, reply
