// The beds of plane contacts, all in one go, and what they carry at rest.

#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

#include "bed.hpp"
#include "canonical.hpp"
#include "first_exit.hpp"
#include "frame.hpp"
#include "hull.hpp"

namespace holdfast {

constexpr double PLANE = 1e-6;  // distance of corners from one plane, relative to the size of the contact, that is
                                // rounding

// The faces of contacts. Face f has the rings ``ring[f]`` to ``ring[f + 1]`` - 1, its outline first, ring r the corners
// (n, 3) [m] from ``corner[r]`` to ``corner[r + 1]`` - 1, and contact k the faces ``face[k]`` to ``face[k + 1]`` - 1.
// ``side`` (F,) is 1 where the ``normal`` (F, 3) points into what is beyond, else -1.
struct ContactFaces {
    InMat corners;
    InInts corner, ring;
    InMat normal;
    In mu, side;
    InInts face;
    static constexpr auto fields =
        std::tuple{&ContactFaces::corners, &ContactFaces::corner, &ContactFaces::ring, &ContactFaces::normal,
                   &ContactFaces::mu,      &ContactFaces::side,   &ContactFaces::face};
};

// The beds of those contacts that are plane, which ``kept`` (K,) numbers: edges and hulls (Bed) one after another, from
// ``edge`` and ``side`` (K + 1,) on, ``size`` (K, 2), and the frame (K, 3, 3) and the origin (K, 3) of each (forest.py)
struct ManyBeds {
    std::vector<Int> kept, edge{0}, side{0};
    std::vector<double> edges, hull, size, frame, origin;
};

// Append the bed of the faces from ``begin`` to ``end`` - 1 to ``beds``, if they are plane
inline bool add_bed(const ContactFaces& all, Int begin, Int end, ManyBeds& beds) {
    Axis normal{}, origin{};
    double most = -1.0, total = 0.0;
    std::vector<Axis> normals;
    for (Int f = begin; f < end; ++f) {  // areas and centroids as those of a patch (contacts/interface.py)
        const Axis own{all.normal(f, 0), all.normal(f, 1), all.normal(f, 2)};
        const auto axes = frame_on(own);
        const auto moments = face_moments(all.corners, all.corner.part(all.ring[f], all.ring[f + 1] + 1), axes);
        const Axis centroid = face_centroid(all.corners[all.corner[all.ring[f]]], axes, moments);
        const double area = moments[0];
        for (int k = 0; k < 3; ++k) origin[k] += area * centroid[k];
        total += area;
        normals.push_back({all.side[f] * own[0], all.side[f] * own[1], all.side[f] * own[2]});
        if (area > most) {
            most = area;
            normal = normals.back();
        }
    }
    for (double& each : origin) each /= total;
    const auto frame = frame_on(normal);
    for (const Axis& each : normals) {
        if (each[0] * normal[0] + each[1] * normal[1] + each[2] * normal[2] < 1 - PLANE) return false;
    }
    double size = 0.0, off = 0.0, mu = -1.0;
    bool one_mu = true;
    std::vector<Place> every;
    const std::size_t first = beds.edges.size();
    for (Int f = begin; f < end; ++f) {
        for (Int r = all.ring[f]; r < all.ring[f + 1]; ++r) {
            const InMat ring = all.corners.part(all.corner[r], all.corner[r + 1]);
            const Int count = ring.size();
            const std::size_t begins = every.size();
            for (Int i = 0; i < count; ++i) {
                const auto corner = ring[all.side[f] > 0.0 ? i : count - 1 - i];
                double at[3];
                for (int k = 0; k < 3; ++k) {
                    at[k] = (corner[0] - origin[0]) * frame[k][0] + (corner[1] - origin[1]) * frame[k][1] +
                            (corner[2] - origin[2]) * frame[k][2];
                }
                every.push_back({at[0], at[1]});
                off = std::max(off, std::abs(at[2]));
                size = std::max(size, std::sqrt(at[0] * at[0] + at[1] * at[1]));
            }
            for (Int i = 0; i < count; ++i) {
                const auto [ax, ay] = every[begins + i];
                const auto [bx, by] = every[begins + (i + 1 < count ? i + 1 : 0)];
                if (ax == bx && ay == by) continue;
                beds.edges.insert(beds.edges.end(), {ax, ay, bx, by, all.mu[f]});
                one_mu = one_mu && (mu < 0.0 || mu == all.mu[f]);
                mu = all.mu[f];
            }
        }
    }
    if (off > PLANE * size) {
        beds.edges.resize(first);
        return false;
    }
    const auto hull = convex_hull(every, PLANE * size);
    for (std::size_t i = 0; i < hull.size(); ++i) {
        const auto [ax, ay] = hull[i];
        const auto [bx, by] = hull[i + 1 < hull.size() ? i + 1 : 0];
        const double x = bx - ax, y = by - ay, length = std::sqrt(x * x + y * y);
        const double nx = -y / length, ny = x / length;
        beds.hull.insert(beds.hull.end(), {-(nx * ax + ny * ay), nx, ny});
    }
    beds.edge.push_back(static_cast<Int>(beds.edges.size()) / 5);
    beds.side.push_back(static_cast<Int>(beds.hull.size()) / 3);
    beds.size.insert(beds.size.end(), {size, one_mu ? mu : 0.0});
    for (const Axis& row : frame) beds.frame.insert(beds.frame.end(), row.begin(), row.end());
    beds.origin.insert(beds.origin.end(), origin.begin(), origin.end());
    return true;
}

// The beds of all contacts that are plane
inline ManyBeds beds_of(const ContactFaces& all) {
    ManyBeds beds;
    for (Int k = 0; k + 1 < all.face.size(); ++k) {
        if (add_bed(all, all.face[k], all.face[k + 1], beds)) beds.kept.push_back(k);
    }
    return beds;
}

// The beds of ``ManyBeds``, and the bodies ``beyond`` each, from ``begin`` (K + 1,) on
struct Beds {
    InInts edge, side;
    InMat edges, hull, size;
    InTen frame;
    InMat origin;
    InInts begin, beyond;
    static constexpr auto fields = std::tuple{&Beds::edge,  &Beds::side,   &Beds::edges, &Beds::hull,  &Beds::size,
                                              &Beds::frame, &Beds::origin, &Beds::begin, &Beds::beyond};
};

// What each bed carries (K, 6) of ``wrenches`` (J, 6) about the centres of mass ``com`` (J, 3): N, N x, N y, the force
// and the torque in its plane; the ``share`` (K,) of its friction that it uses for that, as ``share_at_rest`` says; and
// how far inside its hull N acts, times N, ``inside`` (K,)
struct Carried {
    Array<double, 2> carried;
    Array<double> share, inside;
};

inline Carried carried_by(const Beds& beds, InMat com, InMat wrenches) {
    const Int count = beds.size.size();
    Carried found{Array<double, 2>({count, 6}), Array<double>({count}), Array<double>({count})};
    for (Int k = 0; k < count; ++k) {
        const InMat frame = beds.frame[k];
        const In origin = beds.origin[k];
        Axis force{}, torque{};
        for (Int j = beds.begin[k]; j < beds.begin[k + 1]; ++j) {
            const Int body = beds.beyond[j];
            const In own = wrenches[body];
            const double x = com(body, 0) - origin[0], y = com(body, 1) - origin[1], z = com(body, 2) - origin[2];
            for (int i = 0; i < 3; ++i) force[i] += own[i];
            torque[0] += own[3] + (y * own[2] - z * own[1]);
            torque[1] += own[4] + (z * own[0] - x * own[2]);
            torque[2] += own[5] + (x * own[1] - y * own[0]);
        }
        Axis f{}, t{};
        for (int i = 0; i < 3; ++i) {
            f[i] = force[0] * frame(i, 0) + force[1] * frame(i, 1) + force[2] * frame(i, 2);
            t[i] = torque[0] * frame(i, 0) + torque[1] * frame(i, 1) + torque[2] * frame(i, 2);
        }
        const Six carried{-f[2], t[1], -t[0], -f[0], -f[1], -t[2]};
        std::copy(carried.begin(), carried.end(), found.carried.numbers.begin() + 6 * k);
        const Bed bed{beds.edges.part(beds.edge[k], beds.edge[k + 1]), beds.hull.part(beds.side[k], beds.side[k + 1]),
                      beds.size[k]};
        found.share.numbers[k] = share_at_rest(bed, carried);
        double least = std::numeric_limits<double>::infinity();
        for (Int i = 0; i < bed.hull.size(); ++i) {
            const In side = bed.hull[i];
            least = std::min(least, side[0] * carried[0] + side[1] * carried[1] + side[2] * carried[2]);
        }
        found.inside.numbers[k] = least;
    }
    return found;
}

}  // namespace holdfast
