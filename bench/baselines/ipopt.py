"""The optimisation that Nadeau & Kelly compare with, eq. 28-32: a linear program over polygon cones, solved by IPOPT.

As printed: max s subject to equilibrium, |f_t| within an inscribed polygon of 4 or 8 sides (eq. 6) and f_n >= 0; IPOPT
for at most 1,000 iterations. The answer is s if IPOPT solves the program, 0 if it calls it infeasible, and infinity if
it calls it unbounded or runs out of iterations; in the last case the answer can be too high. Engine ``limit`` proves
which of these is true.

What the paper leaves open, and what is chosen here:

- IPOPT's own settings otherwise (tolerance 1e-8, MUMPS), started from zero forces and s = 0, in N and N m, torques
  about each body's centre of mass.
- s is not bounded, as printed. An assembly that falls by itself but that the push would hold up therefore gets a
  finite answer, which is too high. A negative s means that there is no equilibrium under the weight alone and counts
  as infeasible.
- "Unbounded" is IPOPT's Diverging_Iterates. Solved_To_Acceptable_Level counts as solved. Whatever else IPOPT ends with
  (restoration failed, too few degrees of freedom, a search direction too small) is undecided.

Engine ``limit`` solves the same program over the exact cone or over polygons, with certificates (``holdfast.Limit``).

Optional: the extra ``bench`` (casadi, which brings IPOPT).
"""

from __future__ import annotations

import importlib
from types import ModuleType
from typing import Any

import numpy as np
from scipy import sparse

from bench.baselines.answers import Answer, Answers
from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import ContactNodes, contact_nodes, equilibrium_operator
from holdfast.base.errors import HoldfastError, message
from holdfast.engines.forces import FrictionCone
from holdfast.engines.verdict import Status
from holdfast.queries.request import checked_assembly, pushes

POINTS = 20  # contact points an interface
ITERATIONS = 1000
SOLVED = ("Solve_Succeeded", "Solved_To_Acceptable_Level")
INFEASIBLE = ("Infeasible_Problem_Detected",)
ENDLESS = ("Diverging_Iterates", "Maximum_Iterations_Exceeded")


def optimised(
    assembly: Assembly,
    body: str,
    points: Any,  # noqa: ANN401 - (n, 3) or (3,) numbers, checked
    directions: Any,  # noqa: ANN401 - (n, 3) or (3,) numbers, checked
    *,
    sides: int = 4,
    nodes: ContactNodes | None = None,
    seed: int = 0,
) -> Answers:
    """Find the largest push at each point as printed, one program a push; arguments as in ``robustness``.

    ``nodes``: contact nodes; by default POINTS random ones an interface, as the paper samples them, from ``seed``.
    """
    checked_assembly(assembly)
    p, e, W = pushes(assembly, body, points, directions, f"optimised robustness of {body!r}")
    nodes = contact_nodes(assembly, POINTS, "paper", seed) if nodes is None else nodes
    solver, limits = _program(assembly, nodes, FrictionCone("inscribed", sides))
    found = []
    for column in W.T:
        answer = solver(x0=0, p=column, **limits)
        found.append(_answer(solver.stats()["return_status"], float(answer["x"][-1])))
    return Answers.of(f"ipopt ({sides})", body, p, e, found)


def _program(assembly: Assembly, nodes: ContactNodes, cone: FrictionCone) -> tuple[Any, dict[str, Any]]:
    """IPOPT's solver for the variables (f, s), whose parameter is the push, and bounds on variables and constraints."""
    casadi = _casadi()
    G = equilibrium_operator(assembly, nodes)
    C, cones = cone.rows(nodes)
    x = casadi.MX.sym("x", 3 * len(nodes) + 1)
    load = casadi.MX.sym("load", G.shape[0])
    forces, s = x[:-1], x[-1]
    balance = casadi.mtimes(casadi.DM(G), forces) + assembly.weight_wrench() + s * load
    friction = casadi.mtimes(casadi.DM(sparse.csc_matrix(C)), forces)
    problem = {"x": x, "p": load, "f": -s, "g": casadi.vertcat(balance, friction)}
    quiet = {"ipopt.print_level": 0, "ipopt.sb": "yes", "print_time": False, "error_on_fail": False}
    solver = casadi.nlpsol("optimised", "ipopt", problem, quiet | {"ipopt.max_iter": ITERATIONS})
    pressed = np.full(3 * len(nodes) + 1, -np.inf)
    pressed[:-1:3] = 0.0
    slack = [np.zeros(size) if kind == "zero" else np.full(size, -np.inf) for kind, size in cones]
    return solver, {"lbx": pressed, "lbg": np.concatenate([np.zeros(G.shape[0]), *slack]), "ubg": 0}


def _answer(ended: str, s: float) -> Answer:
    """The answer that the paper reads from IPOPT's exit status and last s."""
    if ended in SOLVED and s >= 0:
        return Status.FINITE, s, s, s
    if ended in (*SOLVED, *INFEASIBLE):
        return Status.UNSTABLE, 0.0, 0.0, 0.0
    if ended in ENDLESS:
        return Status.INFINITE, np.inf, 0.0, np.inf
    return Status.UNDECIDED, 0.0, 0.0, np.inf


def _casadi() -> ModuleType:
    try:
        return importlib.import_module("casadi")
    except ImportError:
        remedy = "pip install -e '.[bench]'"
        raise HoldfastError(message("ipopt", "casadi, which brings IPOPT, is not installed", remedy)) from None
