"""Answer jobs by several worker processes on this machine, in the order in which they finish."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from multiprocessing.connection import wait

from holdfast.base.borders.supervisor import Limits, Reply, Supervisor
from holdfast.batches.job import Job, Question

ANSWERED_BY = "holdfast.batches.rows:answered"


def supervisor_for(question: Question, limits: Limits) -> Supervisor:
    """Return the supervisor of a worker that answers this question."""
    setup = Job(0, "", Question(question.verbs, question.options))
    return Supervisor(ANSWERED_BY, setup, limits)


def answered_here(jobs: Iterator[Job], question: Question, limits: Limits, workers: int) -> Iterator[tuple[Job, Reply]]:
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
