"""Answers that can be written as certificates."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from typing import Any, TypeVar

import numpy as np

from holdfast.base.errors import HoldfastError, message
from holdfast.base.files import checked_path, write_atomically
from holdfast.base.values import sealed
from holdfast.certificates.question import Answered, Question
from holdfast.engines.verdict import Status, Verdict
from holdfast.scene.hold import refuse_holds

T = TypeVar("T")


class Asked:
    """An answer that remembers what was asked."""

    @property
    def questions(self) -> tuple[Question, ...]:
        """What was asked; raises HoldfastError for an answer that was saved, pickled or copied."""
        known: tuple[Question, ...] | None = getattr(self, "_questions", None)
        if known is None:
            problem = "the answer does not know its assembly any more, as it was saved or copied"
            raise HoldfastError(message("certificate", problem, "ask anew"))
        return known


class Certified(Asked):
    """An answer that can prove itself to others, as long as it knows what was asked."""

    engine: str
    verdict: Verdict

    def save_certificate(self, path: str | os.PathLike[str], row: int | None = None) -> None:
        """Write a JSON file that proves the answer to anybody, without holdfast; see docs/explanation/certificates.md.

        It lists bodies, contacts and loads, and for one ``row``, by default for all, contact forces that balance a
        multiple of the load, and a motion that proves that a greater multiple is not in equilibrium. All numbers are
        exact. ``holdfast verify`` and ``tools/verify_certificate.py`` check it. Whatever engine answered, the proof is
        that of limit analysis on the contacts as they were found: that an equilibrium exists, or that none does. Where
        one exists beyond the answer, the file says so.

        Raises HoldfastError if there is no exact proof for one of the rows, if there is no such row, or if the answer
        was saved, pickled or copied.
        """
        where = f"certificate {os.fspath(checked_path(path, 'certificate'))}"
        (question,) = self.questions
        count = 0 if question.loads is None else question.loads.shape[1]
        if row is not None and not 0 <= row < count:
            raise HoldfastError(message(where, f"there is no row {row}", f"there are {count}"))
        answers = getattr(self, "answers", None)
        said = Answered(self.engine, self.verdict.status, np.zeros(0) if answers is None else answers.force)
        data = _proved(question, where, range(count) if row is None else [row], said)
        _write(path, [data], where, falls=self.verdict.status is Status.UNSTABLE, several=False)


class CertifiedStates(Asked):
    """An answer about several states of a structure that can prove itself to others."""

    @property
    def falling(self) -> bool:
        """Whether a certificate has to prove that something falls in one of the states."""
        return False

    def save_certificate(self, path: str | os.PathLike[str]) -> None:
        """Write a JSON file that proves to anybody, without holdfast, which states stand; see certificates.md.

        It is a list of certificates, one for each state in order, as those of ``stability``. That every way in or out
        is free, and that bodies do not clamp each other, is not proved.

        Raises HoldfastError if a state cannot be proved exactly to stand or to fall, if there is none, or if the answer
        was saved, pickled or copied and does not know its assembly.
        """
        where = f"certificate {os.fspath(checked_path(path, 'certificate'))}"
        states = [state for state in self.questions if state.assembly.movable]
        if not states:
            raise HoldfastError(message(where, "there is no state to prove", "ask for other bodies"))
        data = [_proved(state, f"{where}: state {k}") for k, state in enumerate(states, 1)]
        _write(path, data, where, falls=self.falling, several=True)


def _proved(
    question: Question, where: str, rows: Sequence[int] = (), answered: Answered | None = None
) -> dict[str, Any]:
    from holdfast.certificates.certificate import Provable  # proofs are for those who ask for them

    refuse_holds(question.assembly.scene.holds, where, "certificates hold contact forces alone: ask without holds")
    return Provable(question).data(where, rows, answered)


def _write(
    path: str | os.PathLike[str], states: Sequence[dict[str, Any]], where: str, *, falls: bool, several: bool
) -> None:
    """Write the certificates of states as a list, or of one alone unless there are ``several``.

    Raises HoldfastError if the answer is that something ``falls`` and the certificates prove that all stand.
    """
    if falls and all(state["proofs"][0]["kind"] == "stands" for state in states):
        problem = "forces that balance exist, so that something falls has no proof: it rests on the engine's own law"
        raise HoldfastError(message(where, problem, "take the answer as an estimate"))
    data = states if several else states[0]
    write_atomically(path, (json.dumps(data, indent=1, ensure_ascii=False) + "\n").encode())


def asking(answer: T, *questions: Question) -> T:
    """Let an answer remember what was asked, and return it."""
    object.__setattr__(answer, "_questions", tuple(sealed(question) for question in questions))
    return answer
