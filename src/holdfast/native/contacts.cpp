// What Python calls of contacts; sizes and indices are checked here.

#include "bindings.hpp"
#include "clipping.hpp"
#include "cuboids.hpp"
#include "features.hpp"
#include "meshes.hpp"
#include "search_mesh.hpp"

namespace holdfast {

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
