"""Several workers on this machine: they answer jobs in whatever order these end."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from multiprocessing.connection import wait

from holdfast.batches.job import Job, Question
from holdfast.batches.keeper import Keeper, Limits, Reply

ANSWERED_BY = "holdfast.batches.rows:answered"


def keeper_for(question: Question, limits: Limits) -> Keeper:
    """Return the keeper of a worker that answers this question."""
    setup = Job(0, "", Question(question.verbs, question.options))
    return Keeper(ANSWERED_BY, setup, limits)


def answered_here(jobs: Iterator[Job], question: Question, limits: Limits, workers: int) -> Iterator[tuple[Job, Reply]]:
    """Yield every job with its reply. One job more than there are workers is drawn.

    It waits for the first worker that ends its own, which is given it before the reply is yielded: neither what becomes
    of replies nor the drawing of jobs costs a worker its time.
    """
    with ExitStack() as stack:
        idle = [stack.enter_context(keeper_for(question, limits)) for _ in range(workers)]
        busy: list[Keeper] = []
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
            wait([keeper.answers for keeper in busy], min(keeper.left for keeper in busy))
            for keeper in list(busy):
                reply = keeper.take()
                if reply is not None:
                    job = keeper.item
                    busy.remove(keeper)
                    idle.append(keeper)
                    give()
                    yield job, reply
