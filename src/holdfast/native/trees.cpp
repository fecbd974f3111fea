// What Python calls of trees; sizes and indices are checked here.

#include <optional>
#include <tuple>
#include <utility>

#include "bindings.hpp"
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

}  // namespace

void bind_trees(nanobind::module_& m) {
    m.attr("NEVER") = NEVER;
    m.attr("TIPS") = TIPS;
    m.attr("SLIDES") = SLIDES;
    m.attr("UNKNOWN") = UNKNOWN;
    m.def(
        "first_exits",
        [](const Bed& bed, In rest, InMat loads, In until) {
            expect_bed(bed);
            expect(loads.size(1) == 6 && until.size() == loads.size(), "loads of six numbers, and an end for each");
            for (double end : until) expect(!(end < 0.0), "ends that are not negative");
            const Six at_rest = six(rest);
            std::pair<Array<double, 2>, Array<Int>> found{Array<double, 2>({loads.size(), 6}),
                                                          Array<Int>({loads.size()})};
            Scratch s;
            for (Int k = 0; k < loads.size(); ++k) {
                s.m = {};  // so that no answer depends on the load before
                double* out = found.first.numbers.data() + 6 * k;
                found.second.numbers[k] = first_exit(bed, at_rest, six(loads[k]), until[k], s, out);
            }
            return found;
        },
        "bed"_a, "rest"_a, "loads"_a, "until"_a, nogil(),
        "Return what ``first_exit`` finds of each of the loads (n, 6): (n, 6) numbers, and the kinds (n,).");
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
