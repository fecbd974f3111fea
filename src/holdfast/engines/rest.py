"""The assembly at rest: contact nodes, contact forces, and the verdict with its evidence.

Where nothing balances, the collapse motion with the least momentum moves the bodies that really fall, and no others.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import NO_NODES, ContactNodes, contact_nodes, held_velocity
from holdfast.assembly.hold_nodes import with_holds
from holdfast.assembly.one_group import part_of
from holdfast.assembly.strengths import with_pull
from holdfast.base.arrays import Float
from holdfast.base.text import listed
from holdfast.conic.solve import ConeProgram, Outcome, solve
from holdfast.engines.forces import ACCEPTED_RESIDUAL, EXACT, FrictionCone, scaled_operator, scaled_wrench, solve_forces
from holdfast.engines.mechanism import Kinematics, Mechanism, about_origin, describe, modes_of, relative_velocity
from holdfast.engines.verdict import Certificate, ContactForces, Status, Verdict

NEGLIGIBLE = 1e-6  # error of a motion; a body that is slower than that, relative to the fastest one, stands still


def least_motion(assembly: Assembly, nodes: ContactNodes, wrench: Float) -> Float | None:
    """Find the twists (J + F, 6) with the least total momentum of the bodies that no contact can resist.

    They are scaled so that the power of ``wrench`` (6J,) is 1, and solve

        min Σ_j m_j |q_j|  s.t.  u = Gᵀq in the dual cones (u_n >= μ |u_t|),  wrench · q = 1.

    Any feasible q proves that no equilibrium exists (Farkas' lemma). The certificate of the force program is feasible
    too, but it may move bodies that need not move. Whoever asks checks the motion, so one at which the solver got stuck
    will do. Returns None if there is none.
    """
    J, count = len(assembly.movable), len(wrench)
    gather = sparse.csr_matrix(scaled_operator(assembly, nodes).T)
    weight = np.ones((len(nodes), 3))
    weight[:, 1:] = nodes.mu[:, None]
    contacts = sparse.diags(weight.ravel()) @ gather
    power = sparse.csr_matrix(scaled_wrench(assembly, nodes, wrench)[None])
    rows, columns = np.arange(7 * J).reshape(J, 7), np.arange(6 * J).reshape(J, 6)
    motion = sparse.csr_matrix((-np.ones(6 * J), (rows[:, 1:].ravel(), columns.ravel())), shape=(7 * J, count))
    speed = sparse.csr_matrix((-np.ones(J), (rows[:, 0], np.arange(J))), shape=(7 * J, J))
    A = sparse.csc_matrix(
        sparse.hstack(
            [
                sparse.vstack([power, -contacts, motion]),
                sparse.vstack([sparse.csr_matrix((1 + contacts.shape[0], J)), speed]),
            ]
        )
    )
    b = np.zeros(A.shape[0])
    b[0] = 1.0
    q = np.concatenate([np.zeros(count), np.ones(J)])
    cones = (("zero", 1), *((("second_order", 3),) * len(nodes)), *((("second_order", 7),) * J))
    solution = solve(ConeProgram(sparse.csc_matrix((len(q), len(q))), q, A, b, cones), tolerance=1e-9)  # type: ignore[arg-type]
    none = solution.outcome in (Outcome.INFEASIBLE, Outcome.UNBOUNDED)
    if none or not solution.residual <= NEGLIGIBLE * np.abs(solution.x).max():
        return None
    scaled = solution.x[:count].reshape(-1, 6)
    size = np.linalg.norm(scaled[:J], axis=1)
    scaled[:J][size < NEGLIGIBLE * size.max(initial=0)] = 0.0
    return np.asarray((nodes.scaled(assembly.equation_scale) * scaled.ravel()).reshape(-1, 6))


CERTIFIED = 1e-6  # largest violation of the dual cone by an accepted certificate, relative to its fastest point
NO_DILATANCY = 1e-6  # ``ForceSolution.dilatancy`` up to which no force counts as caused by dilatancy


@dataclass(frozen=True, eq=False)
class Rest:
    """The nodes of contacts and holds, the forces at rest, and the verdict.

    ``forces`` (I, 3) [N] are along the local axes of each node, and zero if the assembly does not stand. ``fall``
    (6(J + F),) is then the motion that proves it, of bodies and fasteners (hold_nodes.py), if one does.
    """

    nodes: ContactNodes
    forces: Float
    verdict: Verdict
    fall: Float | None = None


def find_rest(assembly: Assembly, wrench: Float, nodes: ContactNodes | None = None, cone: FrictionCone = EXACT) -> Rest:
    """Find contact forces at ``nodes`` that balance ``wrench`` (6J,) [N, N m], and the verdict that follows.

    If ``nodes`` is None, the nodes are all corners of all patches. If there is no equilibrium on the given nodes, the
    corners of the patches decide, because they can carry every load that the whole patches can carry. The holds of the
    scene come with either.
    """
    wrench = with_pull(assembly, wrench)
    given = nodes is not None
    nodes = corner_nodes(assembly) if nodes is None else with_holds(assembly, nodes)
    wrench, nothing = nodes.under(wrench), np.zeros((len(nodes), 3))
    if not assembly.movable:
        return Rest(nodes, nothing, _balanced_verdict(assembly, nodes, nothing, 0.0, 0.0))
    if assembly.hanging:
        return Rest(nodes, nothing, hanging(assembly, assembly.hanging, wrench[: 6 * len(assembly.movable)]))
    tried: list[str] = []
    points, slow = nodes, None
    for tolerance in (1e-10, 1e-10, 1e-7) if given else (1e-10, 1e-7):
        solution = solve_forces(assembly, points, wrench, tolerance=tolerance, cone=cone)
        if solution.forces is not None and solution.residual <= ACCEPTED_RESIDUAL:
            forces, residual = solution.forces, solution.residual
            return Rest(points, forces, _balanced_verdict(assembly, points, forces, residual, solution.dilatancy))
        fall = None if given or solution.forces is not None else _proved_fall(assembly, points, wrench, solution.twists)
        if fall is not None:
            slow = Rest(points, np.zeros((len(points), 3)), *fall)
            if not _hardly_falls(slow.verdict, wrench[: 6 * len(assembly.movable)]):
                return slow
            continue  # forces may balance all but what an accepted residual may be, as on a ball a nanometre off
        shown = "" if np.isinf(solution.residual) else f", residual {solution.residual:.1e} of the weight"
        tried.append(f"{solution.outcome.value} ({solution.iterations} iterations{shown})")
        if given:
            points, given = corner_nodes(assembly), False
    if slow is not None:
        reason = f"{slow.verdict.reason}, but so slowly that rounding may be why"
        return replace(slow, verdict=undecided(reason, mechanism=slow.verdict.mechanism))
    return Rest(nodes, nothing, undecided("the force program was not solved: " + "; then ".join(tried)))


def corner_nodes(assembly: Assembly) -> ContactNodes:
    """Return the corners of all patches, which carry what whole patches can, with the nodes of holds."""
    return with_holds(assembly, contact_nodes(assembly, 4, "corners"))


def contact_forces(assembly: Assembly, nodes: ContactNodes, forces: Float) -> ContactForces:
    """Return local forces (I, 3) [N] in plain cones as the ``ContactForces`` of a verdict, in the world frame.

    Holds have none.
    """
    nodes = nodes.contacts
    forces = forces[: len(nodes)]
    tangential = np.linalg.norm(forces[:, 1:], axis=1)
    limit = nodes.mu * forces[:, 0]
    loaded = forces[:, 0] > 1e-9 * max(assembly.weight, 1e-300)
    usage = np.divide(tangential, limit, out=np.zeros(len(nodes)), where=loaded & (limit > 0))
    return ContactForces(
        points=nodes.points,
        normal=nodes.normals,
        force=nodes.world(forces - np.outer(nodes.pull, [1.0, 0.0, 0.0])),
        interface=nodes.interface,
        usage=usage,
    )


def _balanced_verdict(
    assembly: Assembly, nodes: ContactNodes, forces: Float, residual: float, dilatancy: float
) -> Verdict:
    """Return the STABLE verdict that contact forces prove."""
    contact = contact_forces(assembly, nodes, forces)
    needs_none = dilatancy <= NO_DILATANCY
    forces_and = "contact forces and holds" if assembly.scene.holds else "contact forces"
    reason = f"{forces_and} balance every body" + (
        "; no contact has to slip for them to build up"
        if needs_none
        else "; some contacts would slip while they build up: that they do build up is not shown (self_stress None)"
    )
    return Verdict(
        status=Status.STABLE,
        reason=reason,
        equilibrium_exists=True,
        self_stress=False if needs_none else None,
        forces=contact,
        residual=residual,
    )


def undecided(reason: str, *, mechanism: Mechanism | None = None) -> Verdict:
    """Return an UNDECIDED verdict with its reason; it has no certificate, for that proves a fall."""
    return Verdict(status=Status.UNDECIDED, reason=reason, mechanism=mechanism)


def unstable(reason: str, mechanism: Mechanism, certificate: Certificate) -> Verdict:
    """Return an UNSTABLE verdict: no equilibrium exists, as the motion and its certificate prove."""
    return Verdict(
        status=Status.UNSTABLE,
        reason=reason,
        equilibrium_exists=False,
        mechanism=mechanism,
        certificate=certificate,
    )


def hanging(assembly: Assembly, groups: Sequence[tuple[str, ...]], wrench: Float) -> Verdict:
    """Return the verdict on groups of bodies, given by their names, that no chain of contacts connects to a fixed body.

    They fall under ``wrench`` (6J,) [N, N m], so the verdict is UNSTABLE. It is UNDECIDED if they touch others in a way
    that is not modelled.
    """
    names = tuple(name for group in groups for name in group)
    numbers = np.array([assembly.index[name] for name in names])
    twists = np.zeros((len(assembly.movable), 6))
    texts = []
    for group in groups:
        members = [assembly.index[name] for name in group]
        force = wrench.reshape(-1, 6)[members, :3].sum(0)
        twists[members, :3] = force if np.linalg.norm(force) > 0 else assembly.scene.gravity
        texts.append(_why_unsupported(assembly, group))
    corners = np.vstack([assembly.movable[k].surface_world.vertices for k in numbers])
    kinematics = Kinematics(
        names=names,
        com=assembly.com[numbers],
        numbers=numbers,
        count=len(assembly.movable),
        size=float(np.linalg.norm(np.ptp(corners, axis=0))),
        pairs=(),
        nodes=NO_NODES,
    )
    doubt = doubt_of(assembly, twists)
    firm = firm_fall(assembly, names, wrench) if doubt else None
    mechanism = describe(kinematics, (twists if firm is None else firm)[numbers], "none", dual=True)
    if doubt and firm is None:
        doubts = [doubt] if all(doubt not in text for text in texts) else []
        return undecided("; ".join([*texts, *doubts]), mechanism=mechanism)
    power = float(wrench @ mechanism.twists.ravel())
    return unstable("; ".join(texts), mechanism, Certificate(power, 0.0))


def _why_unsupported(assembly: Assembly, group: tuple[str, ...]) -> str:
    """Say what a group that no contact supports is nearest to, and what may be done about it."""
    nearest = assembly.nearest_support(group) if assembly.detected else None
    text = f"unsupported: {listed(group)}: no chain of contacts leads to a fixed body"
    if nearest is None:
        return text
    inside, outside, gap = nearest
    own = assembly.tolerances.between(assembly.scene.body(inside), assembly.scene.body(outside))
    place = f"{inside} is {gap * 1e3:.3g} mm from {outside}"
    if not assembly.scene.touching(assembly.scene.body(inside), assembly.scene.body(outside)):
        return f"{text}; {place}, but the scene keeps these two apart (excluded): they never touch"
    deep = [o.text for o in assembly.overlaps if set(o.bodies) == {inside, outside}]
    if deep:
        return f"{text}; {deep[0]}"
    if gap <= own.gap:
        angle = f"the angle tolerance is {own.angle:g} degrees"
        return f"{text}; {place}, but only sharp corners or edges meet there ({angle})"
    if gap > 1:
        return f"{text}; {inside} is {gap:.3g} m from {outside}, its nearest: are all poses in metres?"
    remedy = "settle the scene, or raise gap, if they should touch"
    return f"{text}; {place} (the gap tolerance is {own.gap * 1e3:.3g} mm: {remedy})"


def _proved_fall(
    assembly: Assembly, nodes: ContactNodes, wrench: Float, twists: Float | None
) -> tuple[Verdict, Float] | None:
    """Return the verdict that a motion proves, and that motion: the least one, or ``twists`` (J + F, 6) of the program.

    The program for the forces may end in numerical trouble where bodies fall, as a rod on a slope that touches along a
    line. The least motion then proves it, or nothing does, and the result is None. If either presses bodies together at
    a sharp contact, the least motion that such contacts cannot resist either is tried.
    """
    found = None
    for motion in _motions_tried(assembly, nodes, wrench, twists):
        found = falls_by(assembly, nodes, wrench, motion)
        if found[0].status is Status.UNSTABLE:
            break
    return found


def _motions_tried(assembly: Assembly, nodes: ContactNodes, wrench: Float, twists: Float | None) -> Iterator[Float]:
    """Yield the motions that may prove a fall, the least one first."""
    least, sharp = least_motion(assembly, nodes, wrench), assembly.sharpened
    if least is not None:
        yield least
    firm = None if least is None or sharp is assembly else least_motion(sharp, corner_nodes(sharp), wrench)
    yield from (motion for motion in (firm, twists) if motion is not None)


def falls_by(assembly: Assembly, nodes: ContactNodes, wrench: Float, whole: Float) -> tuple[Verdict, Float]:
    """Return UNSTABLE if nothing can resist the motion ``whole`` (J + F, 6), checked anew; else UNDECIDED.

    Also returns the motion at the scale of the mechanism.
    """
    twists = nodes.moving(whole[: len(assembly.movable)].ravel()).reshape(-1, 6)
    velocity = relative_velocity(nodes, assembly.com, twists)
    mode = modes_of(assembly, nodes.contacts, twists[None], velocity[None], dual=True)[0]
    mechanism = describe(Kinematics.of(assembly, nodes), twists, mode, dual=True)
    rest = whole[len(twists) :] * (np.linalg.norm(mechanism.twists) / max(float(np.linalg.norm(twists)), 1e-300))
    motion = np.vstack([mechanism.twists, rest])
    contacts = relative_velocity(nodes, assembly.com, mechanism.twists)
    scaled = np.vstack([contacts, held_velocity(nodes, motion)])
    excess = float((nodes.mu * np.linalg.norm(scaled[:, 1:], axis=1) - scaled[:, 0]).max(initial=0))
    power = float(wrench @ motion.ravel())
    certificate = Certificate(power, excess)
    if not power > 0 or certificate.violation > CERTIFIED:
        reason = f"the solver's proof of collapse does not hold up (violation {certificate.violation:.1e})"
        return undecided(reason, mechanism=mechanism), motion.ravel()
    doubt = doubt_of(assembly, mechanism.twists)
    if doubt:
        reason = f"no equilibrium on the contacts found, but {doubt}"
        return undecided(reason, mechanism=mechanism), motion.ravel()
    forces = "contact forces and holds" if assembly.scene.holds else "contact forces"
    return unstable(f"no {forces} balance every body: {mechanism.text}", mechanism, certificate), motion.ravel()


def _hardly_falls(verdict: Verdict, wrench: Float) -> bool:
    """Say whether the weights gain less power in a fall than forces with an accepted residual may leave them."""
    if verdict.status is not Status.UNSTABLE or verdict.mechanism is None or verdict.certificate is None:
        return False
    speeds = np.linalg.norm(verdict.mechanism.twists.reshape(-1, 2, 3), axis=2) @ (
        1.0,
        verdict.mechanism.kinematics.size,
    )
    usual = float(np.linalg.norm(wrench.reshape(-1, 6)[:, :3], axis=1) @ speeds)
    return verdict.certificate.power <= ACCEPTED_RESIDUAL * usual


def doubt_of(assembly: Assembly, twists: Float, judged: Collection[str] = ()) -> str:
    """Name a pair of bodies that the motion would press together at a contact outside the model, or return "".

    Such a contact may stop the motion ``twists`` (J, 6), so the motion proves no collapse. Where two bodies overlap,
    any motion of one relative to the other counts; at a sharp contact, one that some force of it resists. Pairs of
    bodies that are both ``judged`` are left out.
    """
    fastest = np.abs(twists).max(initial=0.0)
    for overlap in assembly.overlaps:
        if all(name in judged for name in overlap.bodies):
            continue
        of_first, of_second = about_origin(assembly, twists, overlap.bodies)
        if not np.allclose(of_first, of_second, atol=1e-9 * fastest):
            return overlap.text
    sharp = assembly.sharpened
    added = range(len(assembly.interfaces), len(sharp.interfaces))
    unjudged = [k for k in added if not all(name in judged for name in sharp.interfaces[k].bodies)]
    nodes = contact_nodes(sharp, 4, "corners", among=unjudged)
    velocity = relative_velocity(nodes, assembly.com, twists)
    pressed = nodes.mu * np.linalg.norm(velocity[:, 1:], axis=1) - velocity[:, 0] > CERTIFIED * fastest
    if not pressed.any():
        return ""
    a, b = sharp.interfaces[int(nodes.interface[pressed][0])].bodies
    return f"{a} and {b} touch with a sharp corner or edge on another, where no direction of contact is defined"


def firm_fall(assembly: Assembly, names: Sequence[str], wrench: Float) -> Float | None:
    """Return a motion (J, 6) of these bodies, and of others, that falls whatever sharp contacts carry; None if unknown.

    The groups of the bodies are followed with all others that sharp contacts join to them, under ``wrench`` (6J,).
    """
    whole = assembly.sharpened
    if whole is assembly or assembly.scene.holds:
        return None
    groups = {int(whole.group_of[assembly.index[name]]) for name in names}
    part = part_of(whole, tuple(name for group in sorted(groups) for name in whole.groups[group]))
    verdict = find_rest(part.assembly, wrench[part.rows]).verdict
    if verdict.status is not Status.UNSTABLE or verdict.mechanism is None:
        return None
    twists = np.zeros((len(assembly.movable), 6))
    twists[part.members] = verdict.mechanism.twists
    moves = twists[[assembly.index[name] for name in names]].any()
    return twists if moves and not doubt_of(assembly, twists) else None
