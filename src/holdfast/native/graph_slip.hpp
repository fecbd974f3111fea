// Slip at a contact node and through the assembly (eq. 14-22).
//
// The contact force is the one on the RECEIVING body, along its inward normal. Seen from the other body, both the force
// and the frame are reversed. The components of the force therefore stay the same and only the push changes sign: an
// arc from the receiving body back to the other has capacity R_k(f, -e).

#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "span.hpp"

namespace holdfast {

constexpr double DISCRIMINANT = 1e-9;  // relative |d| below which the push counts as parallel to the side of the cone
// c0 over (mu f_n)² below which c0 counts as 0: it is solver noise, and R depends on its square root
constexpr double ON_CONE = 1e-7;

// Return R_k, the largest s >= 0 with |f_t + s e_t| <= mu (f_n + s e_n), or inf if every s >= 0 satisfies this. The
// force is (fn, f1, f2) [N] and the unit push (en, e1, e2), both along (normal, t1, t2). With c0 = mu² f_n² - |f_t|²,
// b = mu² f_n e_n - f_t·e_t and d = mu² e_n² - |e_t|², R_k is the first root of c0 + 2 b s + d s² = 0 on the upper half
// of the cone (f_n + s e_n >= 0). This form has no cancellation and keeps the sign of e_n (eq. 19 prints |e_n|). It
// also works for a force that solver noise puts slightly outside the cone.
inline double node_slip(double fn, double f1, double f2, double mu, double en, double e1, double e2) {
    constexpr double inf = std::numeric_limits<double>::infinity();
    const double et2 = e1 * e1 + e2 * e2;
    if (mu == 0.0) {
        if (et2 > DISCRIMINANT) return 0.0;
        return en >= 0.0 ? inf : std::max(fn, 0.0) / -en;
    }
    fn = std::max(fn, 0.0);
    double c0 = mu * mu * fn * fn - f1 * f1 - f2 * f2;
    if (c0 <= ON_CONE * mu * mu * fn * fn) c0 = 0.0;
    const double b = mu * mu * fn * en - f1 * e1 - f2 * e2;
    double d = mu * mu * en * en - et2;
    if (std::abs(d) <= DISCRIMINANT * (mu * mu * en * en + et2)) d = 0.0;
    const double n = std::sqrt(std::max(b * b - d * c0, 0.0));
    if (d < 0.0 && b > 0.0) return (b + n) / -d;
    if (d < 0.0 || en < 0.0) return n > b ? c0 / (n - b) : 0.0;
    return inf;
}

// Write the capacity (count, 2) [N] of every interface for a push along ``direction`` (3,) (eq. 21). Column 0 is the
// capacity from body a to body b, column 1 that from b to a. ``forces`` (I, 3) [N] are local, ``axes`` (I, 3, 3) are
// the frames of the nodes, and ``owner`` (I,) is the interface of each node.
inline void arc_capacities(InMat forces, InTen axes, In mu, InInts owner, In direction, Mat capacity) {
    capacity.fill(0.0);
    for (Int i = 0; i < forces.size(); ++i) {
        const auto frame = axes[i];
        double en = 0.0, e1 = 0.0, e2 = 0.0;
        for (int k = 0; k < 3; ++k) {
            en += frame(0, k) * direction[k];
            e1 += frame(1, k) * direction[k];
            e2 += frame(2, k) * direction[k];
        }
        const auto f = forces[i];
        capacity(owner[i], 0) += node_slip(f[0], f[1], f[2], mu[i], en, e1, e2);
        capacity(owner[i], 1) += node_slip(f[0], f[1], f[2], mu[i], -en, -e1, -e2);
    }
}

// A graph of ``count`` nodes with arcs from ``tails`` to ``heads``, and memory for a maximum flow through it
struct Network {
    InInts tails, heads;
    Int count;
    Array<double, 2> residual = Array<double, 2>({tails.size(), 2});
    std::vector<Int> parent = std::vector<Int>(count), queue = std::vector<Int>(count);

    // The node at which an arc begins, gone one ``way`` (0) or the other (1)
    Int tail(Int arc, Int way) const { return way == 0 ? tails[arc] : heads[arc]; }
};

// Return the maximum flow from source to sink. Afterwards ``parent`` of a node is not -1 if it is on the source's side
// of a minimum cut. ``capacity`` (arcs, 2) is that from tail to head and that from head to tail. The first pass uses
// unbounded arcs alone: a path of these means an unbounded flow. The second pass takes shortest augmenting paths, and
// counts the capacity of an unbounded arc as more than that of all finite arcs together.
inline double max_flow(Network& network, InMat capacity, Int source, Int sink) {
    constexpr double inf = std::numeric_limits<double>::infinity();
    const Int arcs = network.tails.size();
    const Mat residual = network.residual.view();
    auto& parent = network.parent;
    auto& queue = network.queue;
    double total = 0.0, flow = 0.0;
    for (Int i = 0; i < arcs; ++i) {
        for (int way = 0; way < 2; ++way) {
            residual(i, way) = capacity(i, way);
            if (std::isfinite(capacity(i, way))) total += capacity(i, way);
        }
    }
    const double tiny = 1e-12 * total;
    for (const bool unbounded_only : {true, false}) {
        if (!unbounded_only) {
            for (Int i = 0; i < arcs; ++i) {
                for (int way = 0; way < 2; ++way) {
                    residual(i, way) = std::isfinite(capacity(i, way)) ? capacity(i, way) : 1.0 + total;
                }
            }
        }
        flow = 0.0;
        while (true) {
            std::fill(parent.begin(), parent.end(), -1);
            parent[source] = -2;
            queue[0] = source;
            Int first = 0, last = 1;
            while (first < last && parent[sink] == -1) {
                const Int node = queue[first++];
                for (Int i = 0; i < arcs; ++i) {
                    for (int way = 0; way < 2; ++way) {
                        const Int head = network.tail(i, 1 - way);
                        if (network.tail(i, way) != node || parent[head] != -1) continue;
                        const double room = residual(i, way);
                        if ((unbounded_only && std::isfinite(room)) || room <= tiny) continue;
                        parent[head] = 2 * i + way;
                        queue[last++] = head;
                    }
                }
            }
            if (parent[sink] == -1) break;
            if (unbounded_only) return inf;
            double bottleneck = inf;
            for (Int node = sink; node != source;) {
                const Int i = parent[node] / 2, way = parent[node] % 2;
                bottleneck = std::min(bottleneck, residual(i, way));
                node = network.tail(i, way);
            }
            for (Int node = sink; node != source;) {
                const Int i = parent[node] / 2, way = parent[node] % 2;
                residual(i, way) -= bottleneck;
                residual(i, 1 - way) += bottleneck;
                node = network.tail(i, way);
            }
            flow += bottleneck;
        }
    }
    return flow;
}

}  // namespace holdfast
