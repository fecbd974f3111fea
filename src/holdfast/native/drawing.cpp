// What Python calls of this room; sizes and indices are checked here.

#include "bindings.hpp"
#include "raster.hpp"

namespace holdfast {

void bind_drawing(nanobind::module_& m) {
    m.def(
        "fill_triangles",
        [](InMat pixels, InIntMat triangles, In behind, Mat depth, IntMat seen) {
            expect(pixels.size(1) == 3 && triangles.size(1) == 3, "points and triangles of three numbers");
            expect(behind.size() == triangles.size() && seen.sizes() == depth.sizes(), "arrays of equal sizes");
            for (Int t = 0; t < triangles.size(); ++t) expect_indices(triangles[t], pixels.size(), "a known vertex");
            fill_triangles(pixels, triangles, behind, depth, seen);
        },
        "pixels"_a, "triangles"_a, "behind"_a, "depth"_a, "seen"_a, nogil());
    m.def(
        "draw_lines",
        [](InIntMat seen, InMat depth, InMat normals, InInts body, double scale, double crease_cosine,
           double step_pixels, Span<unsigned char, 2> line) {
            expect(normals.size(1) == 3 && body.size() == normals.size(), "a normal and a body for each triangle");
            expect(seen.sizes() == depth.sizes() && seen.sizes() == line.sizes(), "arrays of equal sizes");
            for (Int row = 0; row < seen.size(); ++row) expect_indices(seen[row], body.size(), "a known triangle", -1);
            draw_lines(seen, depth, normals, body, scale, crease_cosine, step_pixels, line);
        },
        "seen"_a, "depth"_a, "normals"_a, "body"_a, "scale"_a, "crease_cosine"_a, "step_pixels"_a, "line"_a, nogil());
}

}  // namespace holdfast
