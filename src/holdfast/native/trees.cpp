// What Python calls of trees; sizes and indices are checked here.

#include <array>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "bed_of.hpp"
#include "bindings.hpp"
#include "cuts.hpp"
#include "first_exit.hpp"
#include "limit_surface.hpp"

namespace holdfast {

namespace {

void expect_bed(const Bed& bed) {
    expect(bed.edges.size(1) == 5 && bed.hull.size(1) == 3 && bed.size.size() == 2, "edges, a hull and sizes of a bed");
}

Six six(In carried) {
    expect(carried.size() == 6, "six numbers that a bed carries");
    Six found;
    std::copy_n(carried.data(), 6, found.data());
    return found;
}

Array<double> array_of(const Triple& numbers) {
    Array<double> found({3});
    std::copy(numbers.begin(), numbers.end(), found.numbers.begin());
    return found;
}

void expect_faces(const ContactFaces& faces) {
    const Int count = faces.normal.size(), contacts = faces.face.size() - 1, rings = faces.corner.size() - 1;
    expect(faces.corners.size(1) == 3 && faces.normal.size(1) == 3, "corners and normals of three numbers");
    expect(faces.mu.size() == count && faces.side.size() == count, "friction and a side for each face");
    expect(contacts >= 0 && rings >= 0, "where contacts and rings begin");
    expect_begins(faces.face, contacts, count, "where the faces of each contact begin");
    expect_begins(faces.ring, count, rings, "where the rings of each face begin");
    expect_begins(faces.corner, rings, faces.corners.size(), "where the corners of each ring begin");
    for (Int k = 0; k < contacts; ++k) expect(faces.face[k] < faces.face[k + 1], "contacts with faces");
    for (Int k = 0; k < count; ++k) expect(faces.ring[k] < faces.ring[k + 1], "faces with rings");
    for (Int k = 0; k < rings; ++k) expect(faces.corner[k] < faces.corner[k + 1], "rings with corners");
}

void expect_beds(const Beds& beds, Int bodies) {
    const Int count = beds.size.size();
    expect(beds.size.size(1) == 2 && beds.edges.size(1) == 5 && beds.hull.size(1) == 3, "edges, hulls and sizes");
    expect(beds.frame.sizes() == std::array<Int, 3>{count, 3, 3}, "a frame for each bed");
    expect(beds.origin.sizes() == std::array<Int, 2>{count, 3}, "an origin for each bed");
    expect_begins(beds.edge, count, beds.edges.size(), "where the edges of each bed begin");
    expect_begins(beds.side, count, beds.hull.size(), "where the hull of each bed begins");
    expect_begins(beds.begin, count, beds.beyond.size(), "where the bodies beyond each bed begin");
    expect_indices(beds.beyond, bodies, "a known body");
}

}  // namespace

void bind_trees(nanobind::module_& m) {
    m.attr("NEVER") = NEVER;
    m.attr("TIPS") = TIPS;
    m.attr("SLIDES") = SLIDES;
    m.attr("UNKNOWN") = UNKNOWN;
    m.def(
        "cuts_of",
        [](Int count, InIntMat ends) {
            expect(count >= 0 && ends.size(1) == 2, "two ends of each interface");
            for (Int k = 0; k < ends.size(); ++k) expect_indices(ends[k], count, "a known body", -1);
            Cuts found = cuts_of(count, ends);
            return std::tuple{array_of(std::move(found.root)), array_of(std::move(found.begin)),
                              array_of(std::move(found.beyond)), array_of(std::move(found.since)),
                              array_of(std::move(found.interface))};
        },
        "count"_a, "ends"_a, nogil(),
        "Return the bridges (B,) between bodies, as ``Cuts`` has them: the body before each, where the bodies beyond "
        "begin (B + 1,), these, where the interfaces begin (B + 1,), and these.");
    m.def(
        "beds_of",
        [](const ContactFaces& faces) {
            expect_faces(faces);
            ManyBeds found = beds_of(faces);
            const Int count = static_cast<Int>(found.kept.size()), edges = found.edge.back(), sides = found.side.back();
            return std::tuple{array_of(std::move(found.kept)),
                              array_of(std::move(found.edge)),
                              array_of(std::move(found.side)),
                              array_of(std::move(found.edges), std::array<Int, 2>{edges, 5}),
                              array_of(std::move(found.hull), std::array<Int, 2>{sides, 3}),
                              array_of(std::move(found.size), std::array<Int, 2>{count, 2}),
                              array_of(std::move(found.frame), std::array<Int, 3>{count, 3, 3}),
                              array_of(std::move(found.origin), std::array<Int, 2>{count, 3})};
        },
        "faces"_a, nogil(), "Return the numbers of the contacts that are plane, and their beds, as ``ManyBeds`` does.");
    m.def(
        "carried_by",
        [](const Beds& beds, InMat com, InMat wrenches) {
            expect(com.size(1) == 3 && wrenches.size(1) == 6 && com.size() == wrenches.size(),
                   "a wrench for each body");
            expect_beds(beds, com.size());
            Carried found = carried_by(beds, com, wrenches);
            return std::tuple{std::move(found.carried), std::move(found.share), std::move(found.inside)};
        },
        "beds"_a, "com"_a, "wrenches"_a, nogil(),
        "Return what beds carry (K, 6), the share (K,) of friction each uses, and how far inside (K,) of its hull.");
    m.def(
        "first_exits",
        [](const Bed& bed, In rest, InMat loads, In until) {
            expect_bed(bed);
            expect(loads.size(1) == 6 && until.size() == loads.size(), "loads of six numbers, and an end for each");
            for (double end : until) expect(!(end < 0.0), "ends that are not negative");
            const Six at_rest = six(rest);
            std::pair<Array<double, 2>, Array<Int>> found{Array<double, 2>({loads.size(), 7}),
                                                          Array<Int>({loads.size()})};
            Scratch s;
            for (Int k = 0; k < loads.size(); ++k) {
                s.m = {};  // so that no answer depends on the load before
                double* out = found.first.numbers.data() + 7 * k;
                found.second.numbers[k] = first_exit(bed, at_rest, six(loads[k]), until[k], s, out);
            }
            return found;
        },
        "bed"_a, "rest"_a, "loads"_a, "until"_a, nogil(),
        "Return what ``first_exit`` finds of each of the loads (n, 6): (n, 7) numbers, and the kinds (n,).");
    m.def(
        "share_at_rest",
        [](const Bed& bed, In rest) {
            expect_bed(bed);
            return share_at_rest(bed, six(rest));
        },
        "bed"_a, "rest"_a, nogil(), "Return the share of its friction that a bed uses: -1 if not found, 2 if it tips.");
    m.def(
        "sliding_under",
        [](const Bed& bed,
           In carried) -> std::optional<std::tuple<Array<double>, Array<double>, Array<double>, double>> {
            expect_bed(bed);
            const Six all = six(carried);
            const auto found = sliding_under(bed, {all[0], all[1], all[2]}, {all[3], all[4], all[5]});
            if (!found) return std::nullopt;
            return std::tuple{array_of(found->pressure), array_of(found->motion), array_of(found->friction),
                              found->power};
        },
        "bed"_a, "carried"_a, nogil(),
        "Return the pressure (3,) at which a bed slides that carries this (6,), the motion (3,), the field of pressure "
        "(3,) by which friction follows what is carried, and the power of friction.");
    m.def(
        "pressed_parts",
        [](const Bed& bed, In pressure) {
            expect_bed(bed);
            expect(pressure.size() == 3, "three numbers of a pressure");
            Array<double, 2> found({bed.edges.size(), 4});
            for (Int k = 0; k < bed.edges.size(); ++k) {
                const PressedPart part = pressed_part(bed.edge(k), {pressure[0], pressure[1], pressure[2]});
                const double ends[] = {part.ax, part.ay, part.bx, part.by};
                std::copy_n(ends, 4, found.numbers.data() + 4 * k);
            }
            return found;
        },
        "bed"_a, "pressure"_a, nogil(),
        "Return both ends (E, 4) of the part of each edge that presses; all of an edge of which nothing does.");
    m.def(
        "find_pressure",
        [](const Bed& bed, In carried) -> std::optional<Array<double>> {
            expect_bed(bed);
            expect(carried.size() == 3, "three integrals of a pressure");
            Scratch s;
            if (!find_pressure(bed, {carried[0], carried[1], carried[2]}, s, false)) return std::nullopt;
            return array_of(s.p);
        },
        "bed"_a, "carried"_a, nogil(), "Return the pressure (3,) with these integrals (3,).");
    m.def(
        "share_used",
        [](const Bed& bed, In carried) -> std::optional<std::pair<double, double>> {
            expect_bed(bed);
            const Six all = six(carried);
            Scratch s;
            if (!find_pressure(bed, {all[0], all[1], all[2]}, s, false)) return std::nullopt;
            const Share found = share_used(bed, {all[3], all[4], all[5]}, s);
            return std::pair{found.share, found.error};
        },
        "bed"_a, "carried"_a, nogil(), "Return the share of friction that a bed uses, and its relative error.");
    m.def(
        "most_between",
        [](const Bed& bed, In rest, In load, double low, double at, double squares) {
            expect_bed(bed);
            return most_between(bed, six(rest), six(load), low, at, squares);
        },
        "bed"_a, "rest"_a, "load"_a, "low"_a, "at"_a, "squares"_a, nogil(),
        "Return a share of friction that is used at most between two loads.");
}

}  // namespace holdfast
