// What Python calls of triangle surfaces; sizes and indices are checked here.

#include <algorithm>

#include "area.hpp"
#include "bindings.hpp"
#include "meshes.hpp"
#include "reducible.hpp"
#include "roughness.hpp"
#include "topology.hpp"

namespace holdfast {

static void expect_faces(InIntMat faces, Int vertices) {
    expect(faces.size(1) == 3, "faces of three corners");
    expect_rows(faces, vertices, "a known vertex");
}

static void expect_triangles(InMat vertices, InIntMat faces) {
    expect(vertices.size(1) == 3, "points of three numbers");
    expect_faces(faces, vertices.size());
}

// What is measured of each triangle
template <auto measure>
static auto measured(InMat vertices, InIntMat faces) {
    expect_triangles(vertices, faces);
    return measure(vertices, faces);
}

void bind_surfaces(nanobind::module_& m) {
    m.def("area_vectors", &measured<area_vectors>, "vertices"_a, "faces"_a, nogil());
    m.def("areas_of", &measured<areas_of>, "vertices"_a, "faces"_a, nogil());
    m.def("normals_of", &measured<normals_of>, "vertices"_a, "faces"_a, nogil());
    m.def(
        "may_lose_corners",
        [](InMat vertices, InIntMat faces, InIntMat ends, InIntMat beside, InIntMat of_face, double tolerance) {
            expect_triangles(vertices, faces);
            expect(ends.size(1) == 2 && beside.sizes() == ends.sizes(), "edges with two ends and two faces");
            expect(of_face.sizes() == faces.sizes(), "three edges for each face");
            for (Int i = 0; i < ends.size(); ++i) {
                expect_indices(ends[i], vertices.size(), "a known vertex");
                expect_indices(beside[i], faces.size(), "a known face", -1);
            }
            for (Int f = 0; f < faces.size(); ++f) {
                expect_indices(of_face[f], ends.size(), "a known edge");
                for (Int e : of_face[f]) expect(beside(e, 0) == f || beside(e, 1) == f, "edges beside their faces");
                for (Int k = 0; k < 3; ++k) {
                    const Int e = of_face(f, k), from = faces(f, k), to = faces(f, (k + 1) % 3);
                    expect(std::minmax(ends(e, 0), ends(e, 1)) == std::minmax(from, to), "edges between corners");
                }
            }
            for (Int e = 0; e < beside.size(); ++e) {  // so that who goes around a corner stays there
                for (Int f : beside[e]) expect(f < 0 || std::ranges::count(of_face[f], e) > 0, "faces of their edges");
            }
            return may_lose_corners(vertices, faces, ends, beside, of_face, tolerance);
        },
        "vertices"_a, "faces"_a, "ends"_a, "beside"_a, "of_face"_a, "tolerance"_a, nogil());
    m.def(
        "edges_of",
        [](InIntMat faces, Int count) {
            expect_faces(faces, count);
            Edges e = edges_of(faces);
            return std::tuple{std::move(e.ends), std::move(e.of_face), std::move(e.shared), std::move(e.sides),
                              std::move(e.first)};
        },
        "faces"_a, "count"_a, nogil());
    m.def(
        "topology_of",
        [](InMat vertices, InIntMat faces, InMat normals) {
            expect(vertices.size(1) == 3 && normals.size(1) == 3, "points and normals of three numbers");
            expect(normals.size() == faces.size(), "a normal for each face");
            expect_faces(faces, vertices.size());
            Edges e = edges_of(faces);
            auto beside = faces_beside(e);
            auto bend = bends(vertices, faces, normals, std::as_const(beside).view());
            auto [starts, neighbours] = neighbours_of(std::as_const(e.ends).view(), vertices.size());
            const bool closed = std::ranges::all_of(e.shared.numbers, [](Int count) { return count == 2; });
            return std::tuple{std::move(e.ends), std::move(beside),     std::move(bend), std::move(e.of_face),
                              std::move(starts), std::move(neighbours), closed};
        },
        "vertices"_a, "faces"_a, "normals"_a, nogil());
    m.def(
        "regions_of",
        [](InIntMat beside, In bend, double angle, Int count) {
            expect(beside.size(1) == 2 && beside.size() == bend.size(), "two faces and an angle for each edge");
            for (Int i = 0; i < beside.size(); ++i) {
                expect_indices(beside[i], count, "a known face", -1);
                expect(!(std::abs(bend[i]) <= angle) || (beside(i, 0) >= 0 && beside(i, 1) >= 0),
                       "a face on both sides");
            }
            return regions_of(beside, bend, angle, count);
        },
        "beside"_a, "bend"_a, "angle"_a, "count"_a, nogil());
    m.def(
        "median_length",
        [](InMat vertices, InIntMat ends) {
            expect(vertices.size(1) == 3 && ends.size(1) == 2, "points of three numbers, and edges of two ends");
            for (Int i = 0; i < ends.size(); ++i) expect_indices(ends[i], vertices.size(), "a known vertex");
            return median_length(vertices, ends);
        },
        "vertices"_a, "ends"_a, nogil());
    m.def(
        "median_scatter",
        [](InMat vertices, InIntMat faces, In areas, InMat normals, InInts starts, InInts neighbours, Int samples,
           Int least_samples) {
            expect(vertices.size(1) == 3 && normals.size(1) == 3, "points and normals of three numbers");
            expect(normals.size() == faces.size() && areas.size() == faces.size(),
                   "a normal and an area for each face");
            expect_faces(faces, vertices.size());
            expect(starts.size() == vertices.size() + 1 && starts[0] == 0, "a start for each vertex, from 0");
            for (Int v = 0; v < vertices.size(); ++v) expect(starts[v] <= starts[v + 1], "starts that rise");
            expect(starts[vertices.size()] == neighbours.size(), "starts up to the last neighbour");
            expect_indices(neighbours, vertices.size(), "a known neighbour");
            expect(vertices.size() > 0 && samples > 1 && least_samples > 0, "vertices, and two samples or more");
            return median_scatter(vertices, faces, areas, normals, starts, neighbours, samples, least_samples);
        },
        "vertices"_a, "faces"_a, "areas"_a, "normals"_a, "starts"_a, "neighbours"_a, "samples"_a, "least_samples"_a,
        nogil());
}

}  // namespace holdfast
