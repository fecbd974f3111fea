// Checks of meshes, and of pairs of their faces, that Python hands over.

#pragma once

#include "search_mesh.hpp"
#include "span.hpp"

namespace holdfast {

inline void expect_rows(InIntMat index, Int count, const char* what, Int least = 0) {
    for (Int k = 0; k < index.size(); ++k) expect_indices(index[k], count, what, least);
}

inline void expect_sizes(const SearchMesh& mesh) {
    const Int faces = mesh.faces.size(), vertices = mesh.vertices.size(), edges = mesh.edges.size();
    const std::array<Int, 2> rows{faces, 3}, pairs{edges, 2};
    const std::array<Int, 3> corners{faces, 3, 3};
    expect(mesh.faces.sizes() == rows && mesh.of_face.sizes() == rows && mesh.normals.sizes() == rows, "faces");
    expect(mesh.box.size(0) == 2 && mesh.box.size(1) == 3, "a box of two corners");
    expect(mesh.low.sizes() == rows && mesh.high.sizes() == rows, "a box for each face");
    expect(mesh.triangles.sizes() == corners && mesh.outward.sizes() == corners, "three corners for each face");
    expect(mesh.owns_vertex.sizes() == rows && mesh.owns_edge.sizes() == rows, "three marks for each face");
    expect(mesh.facet.size() == faces && mesh.curved.size() == faces, "a mark for each face");
    expect(mesh.vertices.size(1) == 3 && mesh.mean.sizes() == mesh.vertices.sizes(), "vertices with normals");
    expect(mesh.starts.size() == vertices + 1, "neighbours for each vertex");
    expect(mesh.edges.sizes() == pairs && mesh.sides.sizes() == pairs && mesh.bend.size() == edges, "edges");
}

inline void expect_topology(const SearchMesh& mesh) {
    const Int faces = mesh.faces.size(), vertices = mesh.vertices.size(), edges = mesh.edges.size();
    expect_rows(mesh.faces, vertices, "a known vertex");
    expect_rows(mesh.of_face, edges, "a known edge");
    expect_rows(mesh.edges, vertices, "a known vertex");
    expect_rows(mesh.sides, faces, "a known face", -1);
    expect_indices(mesh.starts, mesh.neighbours.size() + 1, "a known neighbour");
    expect_indices(mesh.neighbours, vertices, "a known vertex");
}

inline void expect_pairs(InIntMat pairs, Int of_a, Int of_b) {
    expect(pairs.size(1) == 2, "pairs");
    for (Int k = 0; k < pairs.size(); ++k) {
        expect(pairs(k, 0) >= 0 && pairs(k, 0) < of_a, "a known first of a pair");
        expect(pairs(k, 1) >= 0 && pairs(k, 1) < of_b, "a known second of a pair");
    }
}

inline void expect_pairs(InIntMat pairs, const SearchMesh& a, const SearchMesh& b) {
    expect_sizes(a);
    expect_sizes(b);
    expect_pairs(pairs, a.faces.size(), b.faces.size());
}

}  // namespace holdfast
