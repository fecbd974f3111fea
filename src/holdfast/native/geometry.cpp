// What Python calls of geometry; sizes and indices are checked here.

#include "bindings.hpp"
#include "cells.hpp"
#include "distance.hpp"
#include "hull.hpp"
#include "hull_gauge.hpp"
#include "meshes.hpp"
#include "overlay.hpp"
#include "polygon.hpp"
#include "sweep.hpp"

namespace holdfast {

namespace {

constexpr Int MOST_CELLS_ACROSS = Int{1} << 31;  // so that the number of a cell is an integer

void expect_triangles(InTen triangles, Int size = 3) {
    expect(triangles.size(1) == 3 && triangles.size(2) == size, "triangles of three corners");
}

// Rings of corners one after another, and where each ends
void expect_rings(InMat corners, InInts ends) {
    expect(corners.size(1) == 2, "corners of two numbers");
    expect_indices(ends, corners.size() + 1, "a known corner");
    for (Int k = 1; k < ends.size(); ++k) expect(ends[k - 1] <= ends[k], "ends in ascending order");
}

void expect_boxed(const SweptFaces& faces) {
    expect_triangles(faces.triangles);
    expect(faces.low.sizes() == faces.high.sizes() && faces.low.size(1) == 3, "boxes of two corners");
    expect(faces.low.size() == faces.triangles.size(), "a box for each triangle");
}

}  // namespace

void bind_geometry(nanobind::module_& m) {
    m.attr("SLIGHT") = SLIGHT;
    m.def(
        "rectangle_axes",
        [](InMat hull) {
            expect(hull.size() > 0 && hull.size(1) == 2, "corners of two numbers");
            return rectangle_axes(hull);
        },
        "hull"_a, nogil());
    m.def(
        "convex_hull",
        [](InMat points, double tolerance) {
            expect(points.size() > 0 && points.size(1) == 2, "points of two numbers");
            std::vector<Place> all(static_cast<std::size_t>(points.size()));
            for (Int k = 0; k < points.size(); ++k) all[k] = {points(k, 0), points(k, 1)};
            const auto found = convex_hull(std::move(all), tolerance);
            Array<double, 2> corners({static_cast<Int>(found.size()), 2});
            for (std::size_t k = 0; k < found.size(); ++k) std::copy_n(found[k].data(), 2, &corners.numbers[2 * k]);
            return corners;
        },
        "points"_a, "tolerance"_a, nogil());
    m.def(
        "corner_numbers",
        [](InMat points, InInts order) {
            expect(points.size(1) == 2, "points of two numbers");
            expect_indices(order, points.size(), "a known point");
            return corner_numbers(points, order);
        },
        "points"_a, "order"_a, nogil());
    m.def(
        "groups_apart",
        [](InMat corners, InInts ends, double apart) {
            expect_rings(corners, ends);
            return groups_apart(corners, ends, apart);
        },
        "corners"_a, "ends"_a, "apart"_a, nogil());
    m.def(
        "outlines_of",
        [](InMat corners, InInts ends, double near) {
            expect_rings(corners, ends);
            Outlines found = outlines_of(corners, ends, near);
            return std::tuple{std::move(found.corners), std::move(found.ends), found.known};
        },
        "corners"_a, "ends"_a, "near"_a, nogil());
    m.def(
        "mark_hits",
        [](InMat points, InMat normals, InTen triangles, double length, Span<bool> result) {
            expect(points.size(1) == 3 && points.sizes() == normals.sizes(), "points and normals of three numbers");
            expect(result.size() == points.size(), "a result for each point");
            expect_triangles(triangles);
            mark_hits(points, normals, triangles, length, result);
        },
        "points"_a, "normals"_a, "triangles"_a, "length"_a, "result"_a, nogil());
    m.def(
        "cut_by_grid",
        [](InTen triangles, In step, Int columns, InIntMat first, InIntMat last) {
            expect_triangles(triangles, 2);
            expect(step.size() == 2 && columns >= 0 && columns <= MOST_CELLS_ACROSS, "a grid");
            expect(first.size(1) == 2 && first.sizes() == last.sizes() && first.size() == triangles.size(),
                   "cells for each triangle");
            expect_rows(first, MOST_CELLS_ACROSS, "a cell");
            expect_rows(last, MOST_CELLS_ACROSS, "a cell");
            for (Int t = 0; t < last.size(); ++t) expect(last(t, 1) <= columns, "cells within the columns");
            return cut_by_grid(triangles, step, columns, first, last);
        },
        "triangles"_a, "step"_a, "columns"_a, "first"_a, "last"_a, nogil());
    m.def(
        "winding_numbers",
        [](InMat points, InMat vertices, InIntMat faces) {
            expect(points.size(1) == 3 && vertices.size(1) == 3 && faces.size(1) == 3, "points of three numbers");
            expect_rows(faces, vertices.size(), "a known vertex");
            return winding_numbers(points, vertices, faces);
        },
        "points"_a, "vertices"_a, "faces"_a, nogil());
    m.def(
        "nearest_of_pairs",
        [](InMat points, InTen triangles, InIntMat pairs) {
            expect(points.size(1) == 3, "points of three numbers");
            expect_triangles(triangles);
            expect_pairs(pairs, points.size(), triangles.size());
            return nearest_of_pairs(points, triangles, pairs);
        },
        "points"_a, "triangles"_a, "pairs"_a, nogil());
    m.def(
        "squared_distances",
        [](InMat points, InTen triangles) {
            expect(points.size(1) == 3, "points of three numbers");
            expect_triangles(triangles);
            return squared_distances(points, triangles);
        },
        "points"_a, "triangles"_a, nogil());
    m.def(
        "hull_gauge",
        [](InMat known, In price, InMat points, double rounding) {
            expect(known.size(1) == points.size(1) && known.size() == price.size(), "points, each with its price");
            expect(known.size() >= 2 * known.size(1), "points along all axes");
            return hull_gauge(known, price, points, rounding);
        },
        "known"_a, "price"_a, "points"_a, "rounding"_a, nogil());
    m.def(
        "add_moments",
        [](InMat ring, Vec total) {
            expect(ring.size(1) == 2 && total.size() == 6, "corners of two numbers, and six integrals");
            add_moments(ring, total);
        },
        "ring"_a, "total"_a, nogil());
    m.def(
        "measures_of",
        [](InTen rings) {
            expect(rings.size(2) == 2 && rings.size(1) <= 8, "up to eight corners of two numbers");
            return measures_of(rings);
        },
        "rings"_a, nogil());
    m.def(
        "shared_parts",
        [](const SweptFaces& ours, const SweptFaces& theirs, double least) {
            expect_boxed(ours);
            expect_boxed(theirs);
            return shared_parts(ours, theirs, least);
        },
        "ours"_a, "theirs"_a, "least"_a, nogil());
}

}  // namespace holdfast
