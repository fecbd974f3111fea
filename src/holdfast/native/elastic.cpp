// What Python calls of the elastic model; sizes and indices are checked here.

#include <optional>
#include <tuple>
#include <utility>

#include "bindings.hpp"
#include "concentrated.hpp"
#include "expected.hpp"
#include "fronts.hpp"
#include "law.hpp"
#include "ordering.hpp"
#include "runs.hpp"
#include "sparse.hpp"

namespace holdfast {

namespace {

void expect_stiffness(const Elastic& m, InTen K) {
    expect(K.sizes() == m.bonded.sizes(), "a stiffness for each sheet");
}

void expect_sheet(const Elastic& m, Int p, In six) {
    expect(p >= 0 && p < m.a.size() && six.size() == 6, "a known sheet, and six numbers");
}

// A part of the memory of a system as an array that Python may write to
template <auto member>
nanobind::ndarray<nanobind::numpy, double> part_of(Work& work) {
    const auto& part = work.*member;
    constexpr std::size_t axes = std::tuple_size_v<std::remove_cvref_t<decltype(part.sizes())>>;
    std::size_t shape[axes];
    for (std::size_t i = 0; i < axes; ++i) shape[i] = static_cast<std::size_t>(part.sizes()[i]);
    return nanobind::ndarray<nanobind::numpy, double>(part.data(), axes, shape, nanobind::handle());
}

// Python's way to the memory of a system, which lives as long as an array of it does
void bind_work(nanobind::module_& m) {
    constexpr auto kept = nanobind::rv_policy::reference_internal;
    nanobind::class_<Work>(m, "Work")
        .def(
            "__init__",
            [](Work* self, const Elastic& model, const std::optional<Fronts>& fronts) {
                expect_model(model);
                const Int n = model.wrench.size(), sheets = model.a.size();
                if (fronts) expect_fronts(*fronts, n, sheets);
                new (self) Work(n, sheets, fronts ? &*fronts : nullptr);
            },
            "model"_a, "fronts"_a.none())
        .def_prop_ro("K", part_of<&Work::K>, kept)
        .def_prop_ro("w", part_of<&Work::w>, kept)
        .def_prop_ro("c", part_of<&Work::c>, kept)
        .def_prop_ro("r", part_of<&Work::r>, kept)
        .def_prop_ro("v", part_of<&Work::v>, kept)
        .def_prop_ro("F", part_of<&Work::F>, kept)
        .def_prop_ro("rhs", part_of<&Work::rhs>, kept)
        .def_prop_ro("waits",
                     [](const Work& work) {
                         Array<Int> found({static_cast<Int>(work.books.size())});
                         for (std::size_t k = 0; k < work.books.size(); ++k) found.numbers[k] = work.books[k].waits;
                         return found;
                     })
        .def(
            "fill",
            [](Work& work, double value) {
                for (const Memory* one : {&work.left, &work.upper, &work.front, &work.other, &work.panel}) {
                    std::fill_n(one->data(), one->size(), value);
                }
                std::fill_n(work.A.data(), work.A.size(0) * work.A.size(1), value);
            },
            "value"_a);
}

void bind_law(nanobind::module_& m) {
    m.def(
        "cut",
        [](InInts first, In x, In y, In apart) {
            expect(first.size() > 0 && y.size() == x.size() && apart.size() == x.size(), "arrays of equal sizes");
            expect_begins(first, first.size() - 1, x.size(), "the nodes of each sheet in order");
            const Int count = count_runs(first);
            std::tuple found{Array<Int>({first.size()}), Array<Int>({count + 1}), Array<double, 2>({count, 5})};
            auto& [begins, node, box] = found;
            cut(first, x, y, apart, begins.view(), node.view(), box.view());
            return found;
        },
        "first"_a, "x"_a, "y"_a, "apart"_a, nogil());
    m.def(
        "bond",
        [](const Elastic& model, Ten bonded, Vec still) {
            expect_model(model);
            expect_stiffness(model, bonded);
            expect_displacement(model, still);
            bond(model, bonded, still);
        },
        "model"_a, "bonded"_a, "still"_a, nogil());
    m.def(
        "set_units",
        [](const Elastic& model, Vec unit) {
            expect_model(model);
            expect_displacement(model, unit);
            set_units(model, unit);
        },
        "model"_a, "unit"_a, nogil());
    m.def(
        "sheet_twist",
        [](const Elastic& model, Int p, In q, Vec v) {
            expect_model(model);
            expect_displacement(model, q);
            expect_sheet(model, p, v);
            sheet_twist(model, p, q, v);
        },
        "model"_a, "p"_a, "q"_a, "v"_a, nogil());
    m.def(
        "add_wrenches",
        [](const Elastic& model, InMat wrenches, Vec r) {
            expect_model(model);
            expect_displacement(model, r);
            expect(wrenches.sizes() == std::array<Int, 2>{model.a.size(), 6}, "a wrench for each sheet");
            for (Int p = 0; p < wrenches.size(); ++p) add_wrench(model, p, wrenches[p], 1.0, r);
        },
        "model"_a, "wrenches"_a, "r"_a, nogil());
    m.def(
        "nearest",
        [](const Runs& runs, Int run, In v, double weight) {
            expect(runs.box.size(1) == 5 && run >= 0 && run < runs.box.size() && v.size() == 6, "a known run");
            return nearest(runs, run, v, weight);
        },
        "runs"_a, "run"_a, "v"_a, "weight"_a);
    m.def(
        "evaluate",
        [](const Elastic& model, double weight, In q, Vec r, Ten K) {
            expect_model(model);
            expect_displacement(model, q);
            expect_displacement(model, r);
            expect_stiffness(model, K);
            double v[6], F[6];
            return evaluate(model, weight, q, r, K, Vec(v, {6}), Vec(F, {6}));
        },
        "model"_a, "weight"_a, "q"_a, "r"_a, "K"_a, nogil());
    m.def(
        "node_forces",
        [](const Elastic& model, In q, Mat f) {
            expect_model(model);
            expect_displacement(model, q);
            expect(f.sizes() == std::array<Int, 2>{model.k.size(), 3}, "a force for each node");
            node_forces(model, q, f);
        },
        "model"_a, "q"_a, "f"_a, nogil());
    m.def(
        "without_touching",
        [](const Elastic& model, In q, double rounding) {
            expect_model(model);
            expect_displacement(model, q);
            return without_touching(model, q, rounding);
        },
        "model"_a, "q"_a, "rounding"_a, nogil());
    m.def(
        "next_change",
        [](const Elastic& model, In q, In t) {
            expect_model(model);
            expect_displacement(model, q);
            expect_displacement(model, t);
            return next_change(model, q, t);
        },
        "model"_a, "q"_a, "t"_a, nogil());
    m.def(
        "concentrated",
        [](const Elastic& model, InInts first, InInts a, InInts b, In most, InMat q, Span<unsigned char, 2> found) {
            expect_model(model);
            const Int count = a.size(), bodies = model.wrench.size() / 6;
            expect(b.size() == count && most.size() == count, "arrays of equal sizes");
            expect_begins(first, count, model.k.size(), "the nodes of each contact in order");
            expect_indices(a, bodies, "a known body", -1);
            expect_indices(b, bodies, "a known body", -1);
            expect(q.size(1) == model.wrench.size(), "as many numbers as displacements");
            expect(found.sizes() == std::array<Int, 2>{q.size(), count}, "a place for each contact");
            concentrated(model, first, a, b, most, q, found);
        },
        "model"_a, "first"_a, "a"_a, "b"_a, "most"_a, "q"_a, "found"_a, nogil());
}

void bind_systems(nanobind::module_& m) {
    m.def(
        "order_fronts",
        [](Int count, InInts a, InInts b, InIntMat ranks) {
            expect(count >= 0 && a.size() == b.size(), "two bodies for each sheet");
            expect_indices(a, count, "a known body", -1);
            expect_indices(b, count, "a known body", -1);
            expect(ranks.size(1) == count, "a rank for each body");
            OrderedFronts f = order_fronts(count, a, b, ranks);
            return std::tuple{array_of(std::move(f.first)),  array_of(std::move(f.body)),  array_of(std::move(f.owned)),
                              array_of(std::move(f.onward)), array_of(std::move(f.begin)), array_of(std::move(f.child)),
                              array_of(std::move(f.since)),  array_of(std::move(f.sheet)), array_of(std::move(f.at_a)),
                              array_of(std::move(f.at_b))};
        },
        "count"_a, "a"_a, "b"_a, "ranks"_a, nogil());
    m.def(
        "write_entries",
        [](const Elastic& model, InTen K, Ints rows, Ints columns, Vec values) {
            expect_model(model);
            expect_stiffness(model, K);
            const Int most = 144 * model.a.size();
            expect(rows.size() >= most && columns.size() >= most && values.size() >= most, "room for all entries");
            return write_entries(model, K, rows, columns, values);
        },
        "model"_a, "K"_a, "rows"_a, "columns"_a, "values"_a, nogil());
    m.def(
        "eliminate",
        [](Mat F, Mat P, Ints columns, Int full, double least) {
            const Int size = F.size();
            expect(full >= 0 && full <= size && F.size(1) >= size + 2, "a front with two right-hand sides");
            expect(P.sizes() == std::array<Int, 2>{full, size} && columns.size() == size, "a panel for the front");
            return eliminate(F, P, columns, full, least);
        },
        "F"_a, "P"_a, "columns"_a, "full"_a, "least"_a, nogil());
    m.def(
        "finish",
        [](Mat F, InMat P, Mat X, Int full) {
            const Int size = F.size(), done = X.size();
            expect(full <= size && P.sizes() == std::array<Int, 2>{full, size} && done <= full,
                   "a panel for the front");
            expect(X.size(1) >= size + 2 - done && X.size(1) <= F.size(1) - done, "room for the rows of pivots");
            finish(F, P, X, full);
        },
        "F"_a, "P"_a, "X"_a, "full"_a, nogil());
    m.def(
        "apply_pivots",
        [](Mat F, InMat P, InMat X) {
            const Int size = F.size(), done = X.size();
            expect(P.size() >= done && P.size(1) == size && done <= size, "a panel for the front");
            expect(X.size(1) <= F.size(1) - done && X.size(1) >= P.size() - done, "the rows of pivots");
            apply_pivots(F, done, P, X, done, size, P.size() - done);
        },
        "F"_a, "P"_a, "X"_a, nogil());
    m.def(
        "passes_on",
        [](const Fronts& e, Int k) {
            expect(k >= 0 && k < e.owned.size() && e.begin.size() == e.owned.size() + 1, "a known front");
            return passes_on(e, k);
        },
        "fronts"_a, "k"_a);
    m.def(
        "solve",
        [](const Elastic& model, Work& work, double drag, double corner, const std::optional<Fronts>& fronts,
           double least) {
            expect_model(model);
            const Fronts* chosen = fronts ? &*fronts : nullptr;
            expect_work(work, model, chosen);
            return solve(model, work, drag, corner, chosen, least);
        },
        "model"_a, "work"_a, "drag"_a, "corner"_a, "fronts"_a.none(), "least"_a = 0.0, nogil());
}

}  // namespace

void bind_elastic(nanobind::module_& m) {
    bind_work(m);
    bind_law(m);
    bind_systems(m);
}

}  // namespace holdfast
