// What Python calls of engines; sizes and indices are checked here.

#include <utility>

#include "bindings.hpp"
#include "combination.hpp"
#include "graph_slip.hpp"
#include "node_wrenches.hpp"
#include "peeling.hpp"
#include "sheets.hpp"
#include "topple.hpp"

namespace holdfast {

namespace {

void expect_nodes(InMat forces, InTen axes, In mu, InInts owner, Int count) {
    const Int nodes = forces.size();
    expect(forces.size(1) == 3 && axes.size() == nodes && axes.size(1) == 3 && axes.size(2) == 3, "a frame per force");
    expect(mu.size() == nodes && owner.size() == nodes, "a coefficient and an interface per force");
    expect_indices(owner, count, "a known interface");
}

void expect_arcs(InInts tails, InInts heads, Int count) {
    expect(tails.size() == heads.size(), "a head for each tail");
    expect_indices(tails, count, "a known node");
    expect_indices(heads, count, "a known node");
}

}  // namespace

void bind_engines(nanobind::module_& m) {
    m.attr("BITS") = BITS;
    m.attr("BESIDE") = BESIDE;
    m.attr("NOTHING") = NOTHING;
    m.attr("SLIDING") = SLIDING;
    m.attr("ON_AXIS") = ON_AXIS;
    m.def("node_slip", &node_slip, "fn"_a, "f1"_a, "f2"_a, "mu"_a, "en"_a, "e1"_a, "e2"_a,
          "Return R_k, the largest push along (en, e1, e2) that the force (fn, f1, f2) leaves within its cone.");
    m.def(
        "node_wrenches",
        [](InMat points, InTen axes, InInts a, InInts b, InMat com, InMat forces) {
            const Int nodes = points.size();
            expect(points.size(1) == 3 && com.size(1) == 3, "points of three numbers");
            expect(forces.sizes() == points.sizes(), "a force for each node");
            expect(axes.sizes() == std::array<Int, 3>{nodes, 3, 3}, "axes for each node");
            expect(a.size() == nodes && b.size() == nodes, "two bodies for each node");
            expect_indices(a, com.size(), "a known body", -1);
            expect_indices(b, com.size(), "a known body", -1);
            return node_wrenches(points, axes, a, b, com, forces);
        },
        "points"_a, "axes"_a, "a"_a, "b"_a, "com"_a, "forces"_a, nogil());
    m.def(
        "arc_capacities",
        [](InMat forces, InTen axes, In mu, InInts owner, Int count, In direction) {
            expect(count >= 0 && direction.size() == 3, "a count and a direction");
            expect_nodes(forces, axes, mu, owner, count);
            Array<double, 2> capacity({count, 2});
            arc_capacities(forces, axes, mu, owner, direction, capacity.view());
            return capacity;
        },
        "forces"_a, "axes"_a, "mu"_a, "owner"_a, "count"_a, "direction"_a, nogil(),
        "Return the capacity (count, 2) [N] of every interface, both ways, for a push along a direction (eq. 21).");
    m.def(
        "max_flow",
        [](InInts tails, InInts heads, InMat capacity, Int source, Int sink, Int count, Span<bool> side) {
            expect_arcs(tails, heads, count);
            expect(capacity.size() == tails.size() && capacity.size(1) == 2, "two capacities for each arc");
            expect(source >= 0 && source < count && sink >= 0 && sink < count, "a source and a sink among the nodes");
            expect(side.size() == count, "a place for each node");
            for (Int i = 0; i < tails.size(); ++i) {
                expect(!(capacity(i, 0) < 0.0 || capacity(i, 1) < 0.0), "capacities that are not negative");
            }
            Network network{tails, heads, count};
            const double flow = max_flow(network, capacity, source, sink);
            for (Int node = 0; node < count; ++node) side[node] = network.parent[node] != -1;
            return flow;
        },
        "tails"_a, "heads"_a, "capacity"_a, "source"_a, "sink"_a, "count"_a, "side"_a, nogil(),
        "Return the maximum flow, and write which nodes (count,) are on the source's side of a minimum cut.");
    m.def(
        "slip_many",
        [](InMat forces, InTen axes, In mu, InInts owner, InInts tails, InInts heads, Int count, InInts sources,
           InMat directions, Span<bool, 2> side) {
            expect_arcs(tails, heads, count);
            expect_nodes(forces, axes, mu, owner, tails.size());
            expect_indices(sources, count, "a known node");
            expect(directions.size() == sources.size() && directions.size(1) == 3, "a direction for each source");
            expect(side.size() == sources.size() && side.size(1) == count, "a place for each source and node");
            Array<double> strength({sources.size()});
            Array<double, 2> capacity({tails.size(), 2});
            Network network{tails, heads, count};
            for (Int q = 0; q < sources.size(); ++q) {
                arc_capacities(forces, axes, mu, owner, directions[q], capacity.view());
                const double flow = max_flow(network, capacity.view(), sources[q], count - 1);
                strength.numbers[q] = flow;
                for (Int node = 0; node < count; ++node) {
                    side(q, node) = std::isfinite(flow) && network.parent[node] != -1;
                }
            }
            return strength;
        },
        "forces"_a, "axes"_a, "mu"_a, "owner"_a, "tails"_a, "heads"_a, "count"_a, "sources"_a, "directions"_a, "side"_a,
        nogil(),
        "Return R_slip (n,) [N] of n pushes, and write which nodes slide (n, count) (eq. 22).\n\n"
        "Push k acts on body sources[k] along directions[k] (3,). Bodies are the nodes 0..count-2 of the graph, and "
        "the "
        "fixed node is count-1.");
    m.def(
        "first_of_line",
        [](InMat start, InMat direction, double tolerance, Span<bool> fresh) {
            expect(start.size(1) == 3 && direction.sizes() == start.sizes(), "points and directions of three numbers");
            expect(fresh.size() == start.size(), "a place for each segment");
            first_of_line(start, direction, tolerance, fresh);
        },
        "start"_a, "direction"_a, "tolerance"_a, "fresh"_a, nogil(),
        "Write which segments (n,) do not lie on the line of an earlier segment.");
    m.def(
        "axis_torques",
        [](InMat origins, InMat axes, Span<const bool> flat, InMat points, InTen frames, InMat forces, In mu,
           Span<const bool> moving_is_a, double size) {
            const Int nodes = points.size();
            expect(origins.size(1) == 3 && axes.sizes() == origins.sizes() && flat.size() == axes.size(), "axes");
            expect(points.size(1) == 3 && forces.sizes() == points.sizes() && mu.size() == nodes, "forces at points");
            expect(frames.size() == nodes && frames.size(1) == 3 && frames.size(2) == 3, "a frame for each point");
            expect(moving_is_a.size() == nodes, "a side for each point");
            Array<double> torque({2 * origins.size()});
            axis_torques(origins, axes, flat, {points, frames, forces, mu, moving_is_a}, size, torque.view());
            return torque;
        },
        "origins"_a, "axes"_a, "flat"_a, "points"_a, "frames"_a, "forces"_a, "mu"_a, "moving_is_a"_a, "size"_a, nogil(),
        "Return the resisting torque (2m,) [N m] about both senses of every axis, inf where it is blocked.\n\n"
        "The axes are given by origins (m, 3) [m] and unit axes (m, 3). flat (m,) marks axes about which every node "
        "slides. The n nodes are given by points (n, 3) [m], frames (n, 3, 3) with the rows normal (into body b), t1 "
        "and t2, forces (n, 3) [N] on body b in that frame, and moving_is_a (n,), which says whether body a is the "
        "moving one. size [m] is that of the assembly.");
    m.def(
        "combined",
        [](InMat points, InMat known, InIntMat near, In values, InMat axes, double rounding) {
            expect(points.size(1) == 6 && known.size(1) == 6, "loads of six numbers");
            expect(near.size() == points.size() && values.size() == known.size(), "neighbours and known values");
            expect(axes.size() == 2 && axes.size(1) == 6, "bounds along both senses of six axes");
            for (Int i = 0; i < near.size(); ++i) expect_indices(near[i], known.size(), "a known load");
            Array<double> result({points.size()});
            combined(points, known, near, values, axes, rounding, result.view());
            return result;
        },
        "points"_a, "known"_a, "near"_a, "values"_a, "axes"_a, "rounding"_a, nogil(),
        "Return upper bounds (n,) of γ at the loads points (n, 6), from those, values (m,), at the known loads (m, "
        "6).\n\n"
        "near (n, k) are the numbers of the known loads to combine for each point, axes (2, 6) upper bounds of γ along "
        "the positive and the negative direction of each axis, and rounding is the share of a sum that it may hide.");
    m.def(
        "peel",
        [](InMat inward, In mu, InInts node, InInts other, InInts first, Span<bool> left) {
            const Int entries = node.size(), bodies = first.size() - 1;
            expect(inward.size() == entries && inward.size(1) == 3 && mu.size() == entries && other.size() == entries,
                   "as many normals, coefficients and bodies as nodes");
            expect(bodies >= 0, "where the entries of bodies begin");
            for (Int body = 0; body <= bodies; ++body) {
                expect(first[body] >= (body > 0 ? first[body - 1] : 0) && first[body] <= entries, "runs of entries");
            }
            expect_indices(node, left.size(), "a known node");
            expect_indices(other, bodies, "a known body", -1);
            peel(inward, mu, node, other, first, left);
        },
        "inward"_a, "mu"_a, "node"_a, "other"_a, "first"_a, "left"_a, nogil(),
        "Clear left (I,) at nodes of one-sided bodies.\n\n"
        "Body j has the entries first[j] to first[j + 1] - 1. Each of them is a node with its normal inward (3,), its "
        "friction coefficient and the other body, -1 if that is fixed.");
    m.def(
        "sheets_begin",
        [](InMat points, InTen axes, InInts interface, double flat) {
            expect(points.size(1) == 3 && axes.size() == points.size() && axes.size(1) == 3 && axes.size(2) == 3,
                   "a frame for each point");
            expect(interface.size() == points.size(), "an interface for each point");
            return sheets_begin(points, axes, interface, flat);
        },
        "points"_a, "axes"_a, "interface"_a, "flat"_a, nogil(),
        "Return the numbers (P + 1,) of the nodes at which the P sheets begin, and the number of nodes.");
    m.def(
        "place_sheets",
        [](InMat points, InTen axes, InInts first, InInts a, InInts b, InMat com, InMat own, double size, Vec x, Vec y,
           Ten turned, Mat arm_a, Mat arm_b) {
            const Int nodes = points.size(), sheets = a.size();
            expect(points.size(1) == 3 && axes.size() == nodes && axes.size(1) == 3 && axes.size(2) == 3,
                   "a frame for each point");
            expect(x.size() == nodes && y.size() == nodes, "a place for each point");
            expect(first.size() == sheets + 1 && b.size() == sheets, "bodies for each sheet");
            for (Int p = 0; p < sheets; ++p) {
                expect(first[p] >= 0 && first[p] < first[p + 1] && first[p + 1] <= nodes, "sheets of known nodes");
            }
            expect(com.size(1) == 3 && own.size() == 3 && own.size(1) == 3, "centres of mass and three axes");
            expect_indices(a, com.size(), "a known body", -1);
            expect_indices(b, com.size(), "a known body", -1);
            expect(turned.size() == sheets && turned.size(1) == 3 && turned.size(2) == 3, "axes for each sheet");
            expect(arm_a.size() == sheets && arm_a.size(1) == 3 && arm_b.sizes() == arm_a.sizes(),
                   "arms of each sheet");
            place_sheets(points, axes, first, a, b, com, own, size, {x, y, turned, arm_a, arm_b});
        },
        "points"_a, "axes"_a, "first"_a, "a"_a, "b"_a, "com"_a, "own"_a, "size"_a, "x"_a, "y"_a, "turned"_a, "arm_a"_a,
        "arm_b"_a, nogil(),
        "Write the places x, y of all nodes, and axes (turned) and arms of all sheets; arms of fixed bodies remain.");
    m.def(
        "snapped_number",
        [](double value, double size, int bits) {
            expect(bits >= 0 && bits < 64, "a number of digits");
            return snapped_number(value, snapping_step(size, bits));
        },
        "value"_a, "size"_a, "bits"_a, "Round a value to so many binary digits relative to a size.");
}

}  // namespace holdfast
