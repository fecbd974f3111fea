// What Python calls of contacts; sizes and indices are checked here.

#include "bindings.hpp"
#include "clipping.hpp"
#include "cover.hpp"
#include "cuboids.hpp"
#include "features.hpp"
#include "meshes.hpp"
#include "search_mesh.hpp"

namespace holdfast {

static void expect_patches(const Patches& patches) {
    const Int count = patches.rings.size();
    expect(patches.corners.size(1) == 3, "corners of three numbers");
    expect(patches.facing.size() == count && patches.facing.size(1) == 3, "a normal for each patch");
    expect(patches.frames.size() == count && patches.frames.size(1) == 2 && patches.frames.size(2) == 3,
           "two tangents for each patch");
    Int before = 0;
    for (Int stop : patches.stops) expect(std::exchange(before, stop) < stop, "rings with corners");
    expect(before == patches.corners.size(), "a ring for each corner");
    before = 0;
    for (Int end : patches.rings) expect(std::exchange(before, end) < end, "patches with rings");
    expect(before == patches.stops.size(), "a patch for each ring");
}

void bind_contacts(nanobind::module_& m) {
    m.attr("LARGE_BOX") = LARGE_BOX;
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
    m.def(
        "covered",
        [](InTen ends, InMat normals, In alike, InMat corners, InInts stops, InInts rings, InMat facing, InTen frames,
           double gap) {
            expect(ends.size(1) == 2 && ends.size(2) == 3, "two ends of three numbers");
            expect(normals.size() == ends.size() && normals.size(1) == 3, "a normal for each feature");
            expect(alike.size() == ends.size(), "a cosine for each feature");
            const Patches patches{corners, stops, rings, facing, frames};
            expect_patches(patches);
            Covered found = covered(ends, normals, alike, patches, gap);
            return std::tuple{std::move(found.marks), std::move(found.open)};
        },
        "ends"_a, "normals"_a, "alike"_a, "corners"_a, "stops"_a, "rings"_a, "facing"_a, "frames"_a, "gap"_a, nogil());
    m.def(
        "patches_along",
        [](InMat ends, In normal, double alike, InMat corners, InInts stops, InInts rings, InMat facing, InTen frames,
           double gap) {
            expect(ends.size() == 2 && ends.size(1) == 3 && normal.size() == 3, "two ends, and a normal");
            const Patches patches{corners, stops, rings, facing, frames};
            expect_patches(patches);
            return patches_along(ends, normal, alike, patches, gap);
        },
        "ends"_a, "normal"_a, "alike"_a, "corners"_a, "stops"_a, "rings"_a, "facing"_a, "frames"_a, "gap"_a, nogil());
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
        "flush_faces",
        [](InTen bodies, InIntMat pairs, InIntMat along, In same) {
            expect(bodies.size(1) == 5 && bodies.size(2) == 3, "cuboids of five rows");
            expect(pairs.size(1) == 2 && pairs.sizes() == along.sizes() && same.size() == pairs.size(), "pairs");
            expect_rows(pairs, bodies.size(), "a known cuboid");
            expect_rows(along, 3, "an axis");
            return flush_faces(bodies, pairs, along, same);
        },
        "bodies"_a, "pairs"_a, "along"_a, "same"_a, nogil());
}

}  // namespace holdfast
