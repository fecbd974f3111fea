// Contacts of vertices and edges: where a corner or an edge of one surface is nearest to the other.
//
// A feature (an edge or a vertex) touches only where it is a local minimum of the distance along the contact normal:
// the surface around it leads away from the other body, up to the angle tolerance. The normal is that of the touched
// face, or the cross product of two edges. If faces meet at a smooth edge, as on a tessellated curve, the contact may
// be between them and takes the mean of their normals. On a sharp edge or corner the normal is undefined, so there is
// no contact.

#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "local_surface.hpp"
#include "search_mesh.hpp"
#include "span.hpp"
#include "vec3.hpp"

namespace holdfast {

constexpr double NEAR_PARALLEL = 0.02;  // sine of the angle below which the cross product of two edges is not reliable
constexpr Int FEATURE_ROW = 13;  // numbers of a contact: two ends (3 each), normal (3), two heights, inset, blended
// largest distance beyond an edge at which a point touches a face, over its height
inline const double WIDEST = 1.001 * std::tan(SMOOTH / 2);

struct FeatureRow {
    double ends[2][3], normal[3], heights[2], inset, blended;
};
static_assert(sizeof(FeatureRow) == FEATURE_ROW * sizeof(double));

// Tell whether a vertex or an edge of face i of ``one`` may touch face j of ``other``; only false is certain
inline bool comes_over(const SearchMesh& one, const SearchMesh& other, Int i, Int j, const FeatureLimits& limits) {
    constexpr double inf = std::numeric_limits<double>::infinity();
    const auto triangle = one.triangles[i];
    double low = inf, high = -inf;
    for (Int n = 0; n < 3; ++n) {
        const double h = height_over(other, j, triangle[n]);
        low = std::min(low, h);
        high = std::max(high, h);
    }
    if (low > limits.gap || high < -limits.depth) return false;
    const double slack = limits.tiny + WIDEST * std::max(std::abs(low), std::abs(high));
    for (Int k = 0; k < 3; ++k) {
        double least = inf;
        for (Int n = 0; n < 3; ++n) least = std::min(least, beyond_edge(other, j, k, triangle[n]));
        if (least > slack) return false;
    }
    return true;
}

// Tell whether vertex k of face i of ``one`` touches face j of ``other``; if so, write it to ``row``
inline bool vertex_on_face(const SearchMesh& one, const SearchMesh& other, Int i, Int k, Int j,
                           const FeatureLimits& limits, double sign, FeatureRow& row) {
    const In v = one.triangles[i][k];
    const double h = height_over(other, j, v);
    if (!(-limits.depth <= h && h <= limits.gap && lies_over(other, j, v, h, limits.tiny, limits.strict))) return false;
    double normal[3];
    const bool blended = normal_at(other, j, v, h, limits.tiny, normal);
    if (!vertex_rises(one, one.faces(i, k), normal, limits)) return false;
    for (int m = 0; m < 3; ++m) {
        row.ends[0][m] = row.ends[1][m] = v[m] - h / 2 * normal[m];
        row.normal[m] = sign * normal[m];
    }
    row.heights[0] = row.heights[1] = h;
    row.inset = inset_of(other, j, v);
    row.blended = blended;
    return true;
}

// The interval of shares of its length in which a segment from p to q is over face j; (1, 0) if none.
//
// ``hp`` and ``hq`` [m] are the heights of its ends. It is clipped by -depth <= h <= gap and by the three sides of the
// face; each of these five keeps the part where f(t) = f0 + t (f1 - f0) >= 0.
inline std::pair<double, double> part_over(const SearchMesh& other, Int j, In p, In q, double hp, double hq,
                                           const FeatureLimits& limits) {
    double low = 0.0, high = 1.0;
    for (Int bound = 0; bound < 5; ++bound) {
        double f0, f1;
        if (bound < 2) {
            f0 = bound == 0 ? limits.depth + hp : limits.gap - hp;
            f1 = bound == 0 ? limits.depth + hq : limits.gap - hq;
        } else {
            const Int k = bound - 2;
            const double nearest = hp * hq > 0 ? std::min(std::abs(hp), std::abs(hq)) : 0.0;
            const double slack = slack_at(other.bend[other.of_face(j, k)], nearest, limits.tiny, -limits.tiny);
            f0 = slack - beyond_edge(other, j, k, p);
            f1 = slack - beyond_edge(other, j, k, q);
        }
        if (f0 < 0 && f1 < 0) {
            low = 1.0;
            high = 0.0;
        } else if (f0 < 0) {
            low = std::max(low, f0 / (f0 - f1));
        } else if (f1 < 0) {
            high = std::min(high, f0 / (f0 - f1));
        }
    }
    return {low, high};
}

// Tell whether an edge of ``one`` touches face j of ``other`` along a line; if so, write it to ``row``
inline bool edge_on_face(const SearchMesh& one, const SearchMesh& other, Int edge, Int j, const FeatureLimits& limits,
                         double sign, FeatureRow& row) {
    const In p = one.vertices[one.edges(edge, 0)], q = one.vertices[one.edges(edge, 1)];
    const double hp = height_over(other, j, p), hq = height_over(other, j, q);
    const double x = q[0] - p[0], y = q[1] - p[1], z = q[2] - p[2];
    const double length = std::sqrt(x * x + y * y + z * z);
    if (std::abs(hq - hp) > (limits.sin_angle + std::sin(SMOOTH / 2)) * length) return false;
    const auto [low, high] = part_over(other, j, p, q, hp, hq, limits);
    if ((high - low) * length <= limits.strict) return false;
    const double centre = (low + high) / 2;
    double middle[3], normal[3];
    for (int m = 0; m < 3; ++m) middle[m] = p[m] + centre * (q[m] - p[m]);
    const bool blended = normal_at(other, j, In(middle, {3}), hp + centre * (hq - hp), limits.tiny, normal);
    double slope = 0.0;
    for (int m = 0; m < 3; ++m) slope += (q[m] - p[m]) / length * normal[m];
    const Int left = one.sides(edge, 0), right = one.sides(edge, 1);
    const bool round = other.curved[j] || (left >= 0 && right >= 0 && one.curved[left] && one.curved[right]);
    if (std::abs(slope) > (round ? limits.sin_curved : limits.sin_angle)) return false;
    if (!edge_rises(one, edge, normal, limits)) return false;
    row.inset = inset_of(other, j, In(middle, {3}));
    if (row.inset <= limits.strict) return false;  // it runs along a sharp edge
    for (int e = 0; e < 2; ++e) {
        const double t = e ? high : low;
        const double h = hp + t * (hq - hp);
        for (int m = 0; m < 3; ++m) row.ends[e][m] = p[m] + t * (q[m] - p[m]) - h / 2 * normal[m];
        row.heights[e] = h;
    }
    for (int m = 0; m < 3; ++m) row.normal[m] = sign * normal[m];
    row.blended = blended;
    return true;
}

// Whether a face owns its k-th edge, and that sticks out
inline bool sticks_out(const SearchMesh& mesh, Int face, Int k) {
    const double bend = mesh.bend[mesh.of_face(face, k)];
    return mesh.owns_edge(face, k) && FLAT < bend && bend < std::numeric_limits<double>::infinity();
}

// Find contacts of vertices and edges of ``one`` with faces of ``other``; ``flipped`` if ``one`` is body b
inline void features_on_faces(const SearchMesh& one, const SearchMesh& other, InIntMat pairs, bool flipped,
                              const FeatureLimits& limits, std::vector<FeatureRow>& lines,
                              std::vector<FeatureRow>& points) {
    const double sign = flipped ? 1.0 : -1.0;
    FeatureRow row;
    for (Int pair = 0; pair < pairs.size(); ++pair) {
        const Int i = pairs(pair, flipped ? 1 : 0), j = pairs(pair, flipped ? 0 : 1);
        if (!comes_over(one, other, i, j, limits)) continue;
        for (Int k = 0; k < 3; ++k) {
            if (one.owns_vertex(i, k) && vertex_on_face(one, other, i, k, j, limits, sign, row)) points.push_back(row);
            if (sticks_out(one, i, k) && edge_on_face(one, other, one.of_face(i, k), j, limits, sign, row)) {
                lines.push_back(row);
            }
        }
    }
}

// Tell whether two convex edges cross, away from their ends, and touch; if so, write it to ``row``. The normal is their
// cross product.
inline bool edge_on_edge(const SearchMesh& a, const SearchMesh& b, Int ea, Int eb, const FeatureLimits& limits,
                         FeatureRow& row) {
    const In p = a.vertices[a.edges(ea, 0)], q = a.vertices[a.edges(ea, 1)];
    const In r = b.vertices[b.edges(eb, 0)], s = b.vertices[b.edges(eb, 1)];
    const double ux = q[0] - p[0], uy = q[1] - p[1], uz = q[2] - p[2];
    const double wx = s[0] - r[0], wy = s[1] - r[1], wz = s[2] - r[2];
    double n[3] = {uy * wz - uz * wy, uz * wx - ux * wz, ux * wy - uy * wx};
    const double uu = ux * ux + uy * uy + uz * uz, ww = wx * wx + wy * wy + wz * wz;
    const double cross = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (cross <= NEAR_PARALLEL * std::sqrt(uu * ww)) return false;
    const double dx = r[0] - p[0], dy = r[1] - p[1], dz = r[2] - p[2];
    const double h = (dx * n[0] + dy * n[1] + dz * n[2]) / cross;
    if (std::abs(h) > limits.gap) return false;  // the depth is never larger than the gap
    const double ud = ux * dx + uy * dy + uz * dz, wd = wx * dx + wy * dy + wz * dz, uw = ux * wx + uy * wy + uz * wz;
    const double determinant = uu * ww - uw * uw;
    const double t = (ud * ww - wd * uw) / determinant, o = (ud * uw - wd * uu) / determinant;
    const double within_a = limits.strict / std::sqrt(uu), within_b = limits.strict / std::sqrt(ww);
    if (!(within_a < t && t < 1 - within_a && within_b < o && o < 1 - within_b)) return false;
    for (double& part : n) part /= cross;
    for (const double sign : {1.0, -1.0}) {
        if (!(-limits.depth <= sign * h && sign * h <= limits.gap)) continue;
        double back[3];
        for (int m = 0; m < 3; ++m) back[m] = -sign * n[m];
        if (!edge_rises(a, ea, back, limits)) continue;
        for (int m = 0; m < 3; ++m) back[m] = sign * n[m];
        if (!edge_rises(b, eb, back, limits)) continue;
        for (int m = 0; m < 3; ++m) {
            row.ends[0][m] = row.ends[1][m] = (p[m] + t * (q[m] - p[m]) + r[m] + o * (s[m] - r[m])) / 2;
            row.normal[m] = back[m];
        }
        row.heights[0] = row.heights[1] = sign * h;
        row.inset = std::min(std::min(t, 1 - t) * std::sqrt(uu), std::min(o, 1 - o) * std::sqrt(ww));
        row.blended = 0.0;
        return true;
    }
    return false;
}

// Rows as an array (n, FEATURE_ROW)
inline Array<double, 2> feature_array(const std::vector<FeatureRow>& rows) {
    Array<double, 2> all({static_cast<Int>(rows.size()), FEATURE_ROW});
    auto at = all.numbers.begin();
    for (const auto& row : rows) {
        for (const auto& end : row.ends) at = std::copy(end, end + 3, at);
        at = std::copy(row.normal, row.normal + 3, at);
        at = std::copy(row.heights, row.heights + 2, at);
        *at++ = row.inset;
        *at++ = row.blended;
    }
    return all;
}

// The lines and the points (n, FEATURE_ROW) where edges and vertices touch, among ``pairs`` (m, 2) of faces
inline std::pair<Array<double, 2>, Array<double, 2>> touching_features(const SearchMesh& a, const SearchMesh& b,
                                                                       InIntMat pairs, const FeatureLimits& limits) {
    std::vector<FeatureRow> lines, points;
    features_on_faces(a, b, pairs, false, limits, lines, points);
    features_on_faces(b, a, pairs, true, limits, lines, points);
    FeatureRow row;
    for (Int pair = 0; pair < pairs.size(); ++pair) {
        const Int i = pairs(pair, 0), j = pairs(pair, 1);
        for (Int k = 0; k < 3; ++k) {
            if (!sticks_out(a, i, k)) continue;
            for (Int m = 0; m < 3; ++m) {
                if (!sticks_out(b, j, m)) continue;
                if (edge_on_edge(a, b, a.of_face(i, k), b.of_face(j, m), limits, row)) points.push_back(row);
            }
        }
    }
    return {feature_array(lines), feature_array(points)};
}

}  // namespace holdfast
