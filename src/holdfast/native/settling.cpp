// What Python calls of settling; sizes and indices are checked here.

#include "bindings.hpp"
#include "facing_triangles.hpp"
#include "meshes.hpp"
#include "near_faces.hpp"
#include "near_points.hpp"

namespace holdfast {

void bind_settling(nanobind::module_& m) {
    m.attr("NEAR_ROW") = NEAR_ROW;
    m.attr("SAME_DEPTH") = SAME_DEPTH;
    m.def(
        "facing_corners",
        [](InTen triangles_a, InMat normals_a, InTen triangles_b, InMat normals_b, InIntMat pairs, double margin,
           double depth, double cos_angle) {
            for (const InTen& all : {triangles_a, triangles_b}) {
                expect(all.size(1) == 3 && all.size(2) == 3, "triangles of three corners");
            }
            expect(normals_a.size(1) == 3 && normals_a.size() == triangles_a.size(), "a normal for each triangle");
            expect(normals_b.size(1) == 3 && normals_b.size() == triangles_b.size(), "a normal for each triangle");
            expect_pairs(pairs, triangles_a.size(), triangles_b.size());
            return facing_corners(triangles_a, normals_a, triangles_b, normals_b, pairs, margin, depth, cos_angle);
        },
        "triangles_a"_a, "normals_a"_a, "triangles_b"_a, "normals_b"_a, "pairs"_a, "margin"_a, "depth"_a, "cos_angle"_a,
        nogil());
    m.def(
        "facing_near",
        [](InIntMat pairs, InMat low_a, InMat high_a, InMat normals_a, InMat low_b, InMat high_b, InMat normals_b,
           double margin) {
            expect(low_a.size(1) == 3 && low_a.sizes() == high_a.sizes() && low_a.sizes() == normals_a.sizes(),
                   "a box and a normal for each face");
            expect(low_b.size(1) == 3 && low_b.sizes() == high_b.sizes() && low_b.sizes() == normals_b.sizes(),
                   "a box and a normal for each face");
            expect_pairs(pairs, low_a.size(), low_b.size());
            return facing_near(pairs, {low_a, high_a, normals_a}, {low_b, high_b, normals_b}, margin);
        },
        "pairs"_a, "low_a"_a, "high_a"_a, "normals_a"_a, "low_b"_a, "high_b"_a, "normals_b"_a, "margin"_a, nogil());
    m.def(
        "mark_unexplained",
        [](InMat rows, double alike, Span<bool> good) {
            expect(rows.size(1) == NEAR_ROW && good.size() == rows.size(), "near points, and a result for each");
            mark_unexplained(rows, alike, good);
        },
        "rows"_a, "alike"_a, "good"_a, nogil());
    m.def(
        "spread_points",
        [](InMat rows, double size, double same) {
            expect(rows.size(1) == NEAR_ROW, "near points");
            return spread_points(rows, size, same);
        },
        "rows"_a, "size"_a, "same"_a, nogil());
}

}  // namespace holdfast
