// What Python calls of contacts; sizes and indices are checked here.

#include "bindings.hpp"
#include "canonical.hpp"
#include "clipping.hpp"
#include "cover.hpp"
#include "cuboids.hpp"
#include "even_nodes.hpp"
#include "features.hpp"
#include "grids.hpp"
#include "matched_weights.hpp"
#include "meshes.hpp"
#include "near_bodies.hpp"
#include "search_mesh.hpp"

namespace holdfast {

namespace {

constexpr Int MOST_NODES = 1'000'000'000;  // of a face, so that their number is an integer
constexpr Int MOST_STEPS = 999'999;        // of a grid along either side

void expect_face(const Face& face) {
    expect(face.corners.size(1) == 2 && face.hull.size(1) == 2 && face.hull.size() > 0, "corners of two numbers");
    expect(face.rectangle.size() == 4 && face.rectangle.size(1) == 2, "a rectangle of four rows");
    expect(face.first.size() > 0, "where the rings begin");
    expect_begins(face.first, face.first.size() - 1, face.corners.size(), "where the rings begin");
    for (Int k = 0; k < face.hull.size(); ++k) {
        expect(std::abs(face.hull(k, 0)) <= 2 && std::abs(face.hull(k, 1)) <= 2, "a hull in the unit square");
    }
}

void expect_steps(Int one, Int other) {
    expect(one > 0 && one <= MOST_STEPS && other > 0 && other <= MOST_STEPS, "a number of steps");
}

}  // namespace

void bind_contacts(nanobind::module_& m) {
    m.attr("LARGE_BOX") = LARGE_BOX;
    m.attr("CANONICAL") = CANONICAL;
    m.attr("FIRST") = FIRST;
    m.attr("FLAT") = FLAT;
    m.attr("SMOOTH") = SMOOTH;
    m.attr("NEAR_PARALLEL") = NEAR_PARALLEL;
    m.def(
        "placed",
        [](InMat points, InIntMat faces, InMat pose) {
            expect(points.size(1) == 3 && faces.size(1) == 3, "points and faces of three numbers");
            expect(pose.size(0) == 4 && pose.size(1) == 4, "a pose of four rows");
            expect_rows(faces, points.size(), "a known vertex");
            return placed(points, faces, pose);
        },
        "points"_a, "faces"_a, "pose"_a, nogil());
    m.def(
        "prepared",
        [](InMat vertices, InIntMat faces, InMat normals, InIntMat ends, In bend) {
            expect(vertices.size(1) == 3 && faces.size(1) == 3, "points and faces of three numbers");
            expect(normals.sizes() == faces.sizes(), "a normal for each face");
            expect(ends.size(1) == 2 && ends.size() == bend.size(), "edges of two ends, and their angles");
            expect_rows(faces, vertices.size(), "a known vertex");
            expect_rows(ends, vertices.size(), "a known vertex");
            Prepared p = prepared(vertices, faces, normals, ends, bend);
            return std::tuple{std::move(p.triangles), std::move(p.low),  std::move(p.high),
                              std::move(p.box),       std::move(p.mean), std::move(p.outward)};
        },
        "vertices"_a, "faces"_a, "normals"_a, "ends"_a, "bend"_a, nogil());
    m.def(
        "outward_of",
        [](InMat vertices, InIntMat faces, InMat normals) {
            expect(vertices.size(1) == 3 && faces.size(1) == 3, "points and faces of three numbers");
            expect(normals.sizes() == faces.sizes(), "a normal for each face");
            expect_rows(faces, vertices.size(), "a known vertex");
            return outward_of(vertices, faces, normals);
        },
        "vertices"_a, "faces"_a, "normals"_a, nogil());
    nanobind::class_<Cover>(m, "Cover")
        .def(
            "__init__",
            [](Cover* self, InMat corners, InInts stops, InInts rings, InMat normals, InTen tangents, double gap) {
                const Int count = rings.size();
                expect(corners.size(1) == 3, "corners of three numbers");
                expect(normals.size() == count && normals.size(1) == 3, "a normal for each patch");
                expect(tangents.sizes() == std::array<Int, 3>{count, 2, 3}, "two tangents for each patch");
                Int before = 0;
                for (Int stop : stops) expect(std::exchange(before, stop) < stop, "rings with corners");
                expect(before == corners.size(), "a ring for each corner");
                before = 0;
                for (Int end : rings) expect(std::exchange(before, end) < end, "patches with rings");
                expect(before == stops.size(), "a patch for each ring");
                new (self) Cover(corners, stops, rings, normals, tangents, gap);
            },
            "corners"_a, "stops"_a, "rings"_a, "normals"_a, "tangents"_a, "gap"_a)
        .def(
            "covered",
            [](const Cover& self, InTen ends, InMat normals, In alike) {
                expect(ends.size(1) == 2 && ends.size(2) == 3, "two ends of three numbers");
                expect(normals.size() == ends.size() && normals.size(1) == 3, "a normal for each feature");
                expect(alike.size() == ends.size(), "a cosine for each feature");
                return self.covered(ends, normals, alike);
            },
            "ends"_a, "normals"_a, "alike"_a, nogil())
        .def(
            "left",
            [](const Cover& self, InMat ends, In normal, double alike, double slack) {
                expect(ends.size() == 2 && ends.size(1) == 3 && normal.size() == 3, "two ends, and a normal");
                return self.left(ends, normal, alike, slack);
            },
            "ends"_a, "normal"_a, "alike"_a, "slack"_a, nogil());
    m.def(
        "near_boxes",
        [](InMat low_a, InMat high_a, InMat low_b, InMat high_b, Int axis, double gap) {
            expect(low_a.size(1) == 3 && low_a.sizes() == high_a.sizes(), "corners of three numbers");
            expect(low_b.size(1) == 3 && low_b.sizes() == high_b.sizes(), "corners of three numbers");
            expect(axis >= 0 && axis < 3, "an axis");
            return near_boxes({low_a, high_a}, {low_b, high_b}, axis, gap);
        },
        "low_a"_a, "high_a"_a, "low_b"_a, "high_b"_a, "axis"_a, "gap"_a, nogil());
    m.def(
        "near_bodies",
        [](InTen boxes, Span<const bool> fixed, Span<const bool> asked, double gap) {
            expect(boxes.size(1) == 2 && boxes.size(2) == 3, "boxes of two corners");
            expect(fixed.size() == boxes.size() && asked.size() == boxes.size(), "two marks for each box");
            return near_bodies(boxes, fixed, asked, gap);
        },
        "boxes"_a, "fixed"_a, "asked"_a, "gap"_a, nogil());
    m.def(
        "near_faces",
        [](const SearchMesh& a, const SearchMesh& b, double gap, Int facet_a, Int facet_b, bool but_facets) {
            expect_sizes(a);
            expect_sizes(b);
            return near_faces(a, b, gap, facet_a, facet_b, but_facets);
        },
        "a"_a, "b"_a, "gap"_a, "facet_a"_a, "facet_b"_a, "but_facets"_a, nogil());
    m.def(
        "clip_faces",
        [](const SearchMesh& a, const SearchMesh& b, InIntMat pairs, double gap, double depth, double flat_cosine,
           double curved_cosine) {
            expect_pairs(pairs, a, b);
            auto found = clip_faces(a, b, pairs, gap, depth, flat_cosine, curved_cosine);
            return std::tuple{std::move(found.corners), std::move(found.counts), std::move(found.normals),
                              std::move(found.heights), std::move(found.curved)};
        },
        "a"_a, "b"_a, "pairs"_a, "gap"_a, "depth"_a, "flat_cosine"_a, "curved_cosine"_a, nogil());
    m.def(
        "touching_features",
        [](const SearchMesh& a, const SearchMesh& b, InIntMat pairs, const FeatureLimits& limits) {
            expect_pairs(pairs, a, b);
            expect_topology(a);
            expect_topology(b);
            return touching_features(a, b, pairs, limits);
        },
        "a"_a, "b"_a, "pairs"_a, "limits"_a, nogil());
    m.def(
        "canonical",
        [](const Patches& patches, In origin, InMat axes) {
            const Int count = patches.normal.size(), rings = patches.corner.size() - 1;
            expect(patches.corners.size(1) == 3 && patches.normal.size(1) == 3, "corners and normals of three numbers");
            expect(origin.size() == 3 && axes.sizes() == std::array<Int, 2>{3, 3}, "a frame");
            expect(rings >= 0 && patches.flipped.size() == count, "where rings begin, and whether each is flipped");
            expect_begins(patches.ring, count, rings, "where the rings of each patch begin");
            expect_begins(patches.corner, rings, patches.corners.size(), "where the corners of each ring begin");
            for (Int k = 0; k < count; ++k) expect(patches.ring[k] < patches.ring[k + 1], "patches with rings");
            for (Int k = 0; k < rings; ++k) expect(patches.corner[k] < patches.corner[k + 1], "rings with corners");
            CanonicalPatches found = canonical(patches, origin, axes);
            return std::tuple{array_of(std::move(found.corners), std::array<Int, 2>{patches.corners.size(), 3}),
                              array_of(std::move(found.corner)),
                              array_of(std::move(found.normal), std::array<Int, 2>{count, 3}),
                              array_of(std::move(found.moments), std::array<Int, 2>{count, 6}),
                              array_of(std::move(found.centroid), std::array<Int, 2>{count, 3})};
        },
        "patches"_a, "origin"_a, "axes"_a, nogil());
    m.def(
        "grids_over",
        [](InMat corners, InInts first, InMat normal, InInts count) {
            expect(corners.size(1) == 3 && normal.size(1) == 3, "corners and normals of three numbers");
            expect(count.size() == normal.size(), "a number of nodes for each face");
            expect_begins(first, normal.size(), corners.size(), "where the corners of each face begin");
            for (Int k = 0; k < normal.size(); ++k) expect(first[k] < first[k + 1], "faces with corners");
            for (const Int each : count) expect(each >= 4 && each <= MOST_NODES, "at least 4 nodes");
            Grids found = grids_over(corners, first, normal, count);
            const Int nodes = static_cast<Int>(found.points.size()) / 3;
            return std::tuple{array_of(std::move(found.sides), std::array<Int, 2>{normal.size(), 2}),
                              array_of(std::move(found.aspect)),
                              array_of(std::move(found.points), std::array<Int, 2>{nodes, 3})};
        },
        "corners"_a, "first"_a, "normal"_a, "count"_a, nogil());
    m.def(
        "nodes_on",
        [](const Face& face, Int across, Int along, Int most, double margin) {
            expect_face(face);
            expect(across > 1 && along > 1, "a grid");
            expect_steps(across, along);
            return as_rows(nodes_on(face, across, along, most, margin));
        },
        "face"_a, "across"_a, "along"_a, "most"_a, "margin"_a, nogil());
    m.def(
        "cells_on",
        [](const Face& face, Int along, Int across) {
            expect_face(face);
            expect_steps(along, across);
            return as_rows(cells_on(face, along, across));
        },
        "face"_a, "along"_a, "across"_a, nogil());
    m.def(
        "nearest_of",
        [](InMat points, InMat places) {
            expect(points.size() > 0 && points.size(1) == 2 && places.size(1) == 2, "points of two numbers");
            return nearest_of(points, places);
        },
        "points"_a, "places"_a, nogil());
    m.def(
        "farthest_of",
        [](InMat candidates, InMat chosen, Int count) {
            expect(candidates.size() > 0 && candidates.size(1) == 2 && chosen.size(1) == 2, "points of two numbers");
            return as_rows(farthest_of(candidates, chosen, count));
        },
        "candidates"_a, "chosen"_a, "count"_a, nogil());
    m.def(
        "corrected",
        [](In given, InMat basis, In wanted, InInts matched) {
            expect(basis.size() == wanted.size() && basis.size(1) == given.size(), "a row for each integral");
            for (const Int count : matched) expect(count > 0 && count <= wanted.size(), "known integrals");
            return corrected(given, basis, wanted, matched);
        },
        "given"_a, "basis"_a, "wanted"_a, "matched"_a, nogil());
    m.def(
        "matched_weights",
        [](InMat nodes, In shares, In moments, double arm, double scale) {
            expect(nodes.size(1) == 2 && nodes.size() == shares.size() && moments.size() == 6, "a share for each node");
            return matched_weights(nodes, shares, moments, arm, scale);
        },
        "nodes"_a, "shares"_a, "moments"_a, "arm"_a, "scale"_a, nogil());
    m.def(
        "cuboid_contacts",
        [](InTen bodies, InIntMat pairs, InMat limits, double rounding, double wide) {
            expect(bodies.size(1) == 5 && bodies.size(2) == 3, "cuboids of five rows");
            expect_pairs(pairs, bodies.size(), bodies.size());
            expect(limits.size() == pairs.size() && limits.size(1) == 3, "three limits for each pair");
            return cuboid_contacts(bodies, pairs, limits, rounding, wide);
        },
        "bodies"_a, "pairs"_a, "limits"_a, "rounding"_a, "wide"_a, nogil());
}

}  // namespace holdfast
