// What Python calls of load paths and of coming to rest; sizes and indices are checked here.

#include <initializer_list>
#include <optional>
#include <utility>

#include "bindings.hpp"
#include "expected.hpp"
#include "path.hpp"
#include "resting.hpp"

namespace holdfast {

namespace {

namespace nb = nanobind;

// A model with its memory and fronts, which fit each other
const Fronts* checked(const Elastic& m, const Work& work, const std::optional<Fronts>& fronts) {
    expect_model(m);
    const Fronts* chosen = fronts ? &*fronts : nullptr;
    expect_work(work, m, chosen);
    return chosen;
}

// The same of a walk in that model
const Fronts* checked(const Elastic& m, const Work& work, const Stepper& stepper, const std::optional<Fronts>& fronts) {
    const Fronts* chosen = checked(m, work, fronts);
    expect_displacement(m, stepper.q);
    return chosen;
}

// As many rows as there are loads, of as many numbers as displacements
void expect_rows(const Elastic& m, InMat one, Int count) {
    expect(one.sizes() == std::array<Int, 2>{count, m.wrench.size()}, "a displacement in each row");
}

void expect_result(const Elastic& m, const PathResult& into, Int count) {
    expect(into.outcome.size() == count && into.systems.size() == count, "a number for each load");
    for (const Vec& one : {into.peak, into.first, into.before, into.sharpest, into.last}) {
        expect(one.size() == count, "a number for each load");
    }
    for (const Mat& one : {into.q, into.motion, into.plane}) expect_rows(m, one, count);
}

template <class Number>
nb::dict numbers(std::initializer_list<std::pair<const char*, Number>> all) {
    nb::dict found;
    for (const auto& [name, number] : all) found[name] = static_cast<Int>(number);
    return found;
}

void bind_numbers(nb::module_& m) {
    m.attr("SLID") = SLID;
    m.attr("SPRING_SHARE") = SPRING_SHARE;
    m.attr("PATH_OUTCOMES") = numbers<PathOutcome>({{"LOST", PathOutcome::LOST},
                                                    {"PEAK", PathOutcome::PEAK},
                                                    {"ENDLESS", PathOutcome::ENDLESS},
                                                    {"REACHED", PathOutcome::REACHED}});
    m.attr("REST_OUTCOMES") = numbers<RestOutcome>(
        {{"LOST", RestOutcome::LOST}, {"RESTS", RestOutcome::RESTS}, {"DRIFTS", RestOutcome::DRIFTS}});
    m.attr("EVENTS") = numbers<Event>({{"BEGUN", Event::BEGUN},
                                       {"ADVANCED", Event::ADVANCED},
                                       {"TORN", Event::TORN},
                                       {"SHORTENED", Event::SHORTENED},
                                       {"NODE_CHANGED", Event::NODE_CHANGED},
                                       {"STUCK", Event::STUCK},
                                       {"PROPORTIONAL", Event::PROPORTIONAL},
                                       {"NO_BEGINNING", Event::NO_BEGINNING},
                                       {"RELEASED", Event::RELEASED},
                                       {"ASTRAY", Event::ASTRAY},
                                       {"FALLEN", Event::FALLEN},
                                       {"FAR", Event::FAR},
                                       {"FLAT", Event::FLAT},
                                       {"ENDLESS", Event::ENDLESS},
                                       {"REACHED", Event::REACHED}});
}

void bind_progress(nb::module_& m) {
    nb::class_<Progress>(m, "Progress")
        .def(nb::init<const StepControl&>(), "pace"_a)
        .def_rw("orientation", &Progress::orientation)
        .def_rw("strength", &Progress::strength)
        .def_rw("elastic", &Progress::elastic)
        .def_rw("s", &Progress::s)
        .def_rw("slope", &Progress::slope)
        .def_rw("by_springs", &Progress::by_springs)
        .def_rw("rest", &Progress::rest)
        .def_rw("step", &Progress::step)
        .def_rw("length", &Progress::length)
        .def_rw("turned", &Progress::turned)
        .def_rw("fastest", &Progress::fastest)
        .def_rw("corner", &Progress::corner)
        .def_rw("doubted", &Progress::doubted)
        .def_rw("highest", &Progress::highest)
        .def_rw("noted", &Progress::noted)
        .def_rw("at_peak", &Progress::at_peak)
        .def_rw("late", &Progress::late)
        .def_rw("dipped", &Progress::dipped)
        .def_rw("first", &Progress::first)
        .def_rw("crest", &Progress::crest)
        .def_rw("trough", &Progress::trough)
        .def_rw("rising_s", &Progress::rising_s)
        .def_rw("rising_slope", &Progress::rising_slope)
        .def_rw("falling_s", &Progress::falling_s)
        .def_rw("falling_slope", &Progress::falling_slope)
        .def_rw("closed", &Progress::closed)
        .def_rw("peaked", &Progress::peaked)
        .def_rw("topped", &Progress::topped)
        .def_rw("slid", &Progress::slid)
        .def_rw("before", &Progress::before)
        .def_rw("flat_since", &Progress::flat_since)
        .def_rw("similar_since", &Progress::similar_since);
    m.def("measure_dip", measure_dip, "now"_a, "rise"_a, "s"_a, "falls"_a);
    m.def("measure_sliding", measure_sliding, "now"_a, "rise"_a, "s"_a, "falls"_a, "slid"_a);
    m.def("passes_over", passes_over, "now"_a, "rise"_a, "s"_a, "falls"_a);
    m.def("hides_dip", hides_dip, "now"_a, "rise"_a, "s"_a, "falls"_a);
    m.def("fall", fall, "low"_a, "high"_a);
    m.def("may_have_fallen", may_have_fallen, "seen"_a, "estimate"_a);
    m.def("appraise", [](Progress& now) { return static_cast<Int>(appraise(now)); }, "now"_a);
    m.def("set_next_step", set_next_step, "now"_a);
    m.def("cubic", cubic, "x"_a, "start"_a, "a"_a, "end"_a, "b"_a);
    m.def("maximum_at", maximum_at, "start"_a, "a"_a, "end"_a, "b"_a);
    m.def("minimum_at", minimum_at, "start"_a, "a"_a, "end"_a, "b"_a);
    m.def("least_slope", least_slope, "start"_a, "a"_a, "end"_a, "b"_a);
    m.def("summit", summit, "start"_a, "a"_a, "end"_a, "b"_a);
}

void bind_newton(nb::module_& m) {
    nb::class_<Iteration>(m, "Iteration")
        .def(
            "__init__",
            [](Iteration* self, bool converged, double s, Int steps, Int systems, Int states, double sign) {
                new (self) Iteration{converged, s, steps, systems, states, sign};
            },
            "converged"_a, "s"_a, "steps"_a, "systems"_a, "states"_a, "sign"_a)
        .def_ro("converged", &Iteration::converged)
        .def_ro("s", &Iteration::s)
        .def_ro("steps", &Iteration::steps)
        .def_ro("systems", &Iteration::systems)
        .def_ro("states", &Iteration::states)
        .def_ro("sign", &Iteration::sign);
    m.def(
        "add_drag",
        [](const Elastic& model, Work& work, double drag, In q, In anchor) {
            expect_model(model);
            expect(work.r.size() == model.wrench.size(), "memory made for a model of this size");
            expect_displacement(model, q);
            expect_displacement(model, anchor);
            add_drag(model, work, drag, q, anchor);
        },
        "model"_a, "work"_a, "drag"_a, "q"_a, "anchor"_a, nogil());
    m.def(
        "unbalance",
        [](const Elastic& model, Work& work, const Balance& balance, In q, double s) {
            expect_model(model);
            expect(work.r.size() == model.wrench.size() && work.K.size() == model.a.size(),
                   "memory made for a model of this size");
            expect_displacement(model, q);
            expect_displacement(model, balance.anchor);
            return unbalance(model, work, balance, q, s);
        },
        "model"_a, "work"_a, "balance"_a, "q"_a, "s"_a, nogil());
    m.def(
        "newton",
        [](const Elastic& model, Work& work, const Balance& balance, Vec q, double s, double level, double tolerance,
           Int most, double least, const std::optional<Fronts>& fronts) {
            const Fronts* chosen = checked(model, work, fronts);
            expect_displacement(model, q);
            expect_displacement(model, balance.anchor);
            Breath breath;
            return newton(model, work, balance, q, s, level, tolerance, most, least, chosen, breath);
        },
        "model"_a, "work"_a, "balance"_a, "q"_a, "s"_a, "level"_a, "tolerance"_a, "most"_a, "least"_a,
        "fronts"_a.none(), nogil());
}

void bind_resting(nb::module_& m) {
    nb::class_<Rest>(m, "Rest")
        .def_prop_ro("outcome", [](const Rest& rest) { return static_cast<Int>(rest.outcome); })
        .def_ro("steps", &Rest::steps)
        .def_ro("drag", &Rest::drag);
    const auto bind = [&m](const char* name, auto search) {
        m.def(
            name,
            [search](const Elastic& model, Work& work, double weight, Vec q, Vec drift, double exact, Int most,
                     const std::optional<Fronts>& fronts) {
                const Fronts* chosen = checked(model, work, fronts);
                expect_displacement(model, q);
                expect_displacement(model, drift);
                Breath breath;
                return search(model, work, weight, q, drift, exact, most, chosen, breath);
            },
            "model"_a, "work"_a, "weight"_a, "q"_a, "drift"_a, "exact"_a, "most"_a, "fronts"_a.none(), nogil());
    };
    bind("lessen_drag", lessen_drag);
    bind("move", move);
    m.def(
        "bond_all",
        [](const Elastic& model, Work& work, In load, Vec q, const std::optional<Fronts>& fronts) {
            const Fronts* chosen = checked(model, work, fronts);
            expect_displacement(model, load);
            expect_displacement(model, q);
            bond_all(model, work, load, q, chosen);
        },
        "model"_a, "work"_a, "load"_a, "q"_a, "fronts"_a.none(), nogil());
    m.def(
        "rests_near",
        [](const Elastic& model, Work& work, Vec q, const std::optional<Fronts>& fronts) {
            const Fronts* chosen = checked(model, work, fronts);
            expect_displacement(model, q);
            Breath breath;
            return rests_near(model, work, q, chosen, breath);
        },
        "model"_a, "work"_a, "q"_a, "fronts"_a.none(), nogil());
}

// A vector of a walk as an array that Python may write to
template <Vec Stepper::* member>
nb::ndarray<nb::numpy, double> vector_of(Stepper& stepper) {
    const Vec& part = stepper.*member;
    return nb::ndarray<nb::numpy, double>(part.data(), {static_cast<std::size_t>(part.size())}, nb::handle());
}

void bind_steps(nb::module_& m) {
    constexpr auto kept = nb::rv_policy::reference_internal;
    nb::class_<Stepper>(m, "Stepper")
        .def(nb::init<In, const StepControl&>(), "stuck"_a, "pace"_a)
        .def_prop_ro(
            "now", [](Stepper& stepper) -> Progress& { return stepper.now; }, kept)
        .def_prop_ro("q", vector_of<&Stepper::q>, kept)
        .def_prop_ro("tangent", vector_of<&Stepper::tangent>, kept)
        .def_prop_ro("trial", vector_of<&Stepper::trial>, kept);
    m.def(
        "begin",
        [](const Elastic& model, Work& work, Stepper& stepper, In start, In load, const std::optional<Fronts>& fronts) {
            const Fronts* chosen = checked(model, work, stepper, fronts);
            expect_displacement(model, start);
            expect_displacement(model, load);
            Breath breath;
            return static_cast<Int>(begin(model, work, stepper, start, load, chosen, breath));
        },
        "model"_a, "work"_a, "stepper"_a, "start"_a, "load"_a, "fronts"_a.none(), nogil());
    m.def(
        "advance",
        [](const Elastic& model, Work& work, Stepper& stepper, const std::optional<Fronts>& fronts) {
            const Fronts* chosen = checked(model, work, stepper, fronts);
            Breath breath;
            return static_cast<Int>(advance(model, work, stepper, chosen, breath));
        },
        "model"_a, "work"_a, "stepper"_a, "fronts"_a.none(), nogil());
    m.def(
        "set_out",
        [](const Elastic& model, Work& work, Stepper& stepper, const std::optional<Fronts>& fronts) {
            const Fronts* chosen = checked(model, work, stepper, fronts);
            Breath breath;
            return set_out(model, work, stepper, chosen, breath);
        },
        "model"_a, "work"_a, "stepper"_a, "fronts"_a.none(), nogil());
    m.def(
        "cross_change",
        [](const Elastic& model, Work& work, Stepper& stepper, const std::optional<Fronts>& fronts) {
            const Fronts* chosen = checked(model, work, stepper, fronts);
            return static_cast<Int>(cross_change(model, work, stepper, chosen));
        },
        "model"_a, "work"_a, "stepper"_a, "fronts"_a.none(), nogil());
    m.def(
        "land",
        [](const Elastic& model, Work& work, Stepper& stepper, double s, double sign) {
            expect_model(model);
            expect_displacement(model, stepper.q);
            expect_displacement(model, work.w);
            land(model, work, stepper, s, sign);
        },
        "model"_a, "work"_a, "stepper"_a, "s"_a, "sign"_a);
    m.def(
        "doubtful",
        [](const Elastic& model, Work& work, Stepper& stepper, const Iteration& point) {
            expect_model(model);
            expect_displacement(model, stepper.q);
            expect_displacement(model, work.w);
            expect(work.K.size() == model.a.size(), "memory made for a model of this size");
            return doubtful(model, work, stepper, point);
        },
        "model"_a, "work"_a, "stepper"_a, "point"_a);
    m.def(
        "strays",
        [](const Elastic& model, Work& work, Stepper& stepper, const Iteration& point, double rise, double falls) {
            expect_model(model);
            expect_displacement(model, stepper.q);
            expect_displacement(model, work.w);
            expect(work.K.size() == model.a.size(), "memory made for a model of this size");
            return strays(model, work, stepper, point, rise, falls);
        },
        "model"_a, "work"_a, "stepper"_a, "point"_a, "rise"_a, "falls"_a);
    m.def(
        "narrow",
        [](Work& work, Stepper& stepper, double s, double sign) {
            expect(work.w.size() == stepper.q.size(), "memory made for a model of this size");
            narrow(work, stepper, s, sign);
        },
        "work"_a, "stepper"_a, "s"_a, "sign"_a);
    m.def(
        "turn",
        [](Work& work, double sign, double orientation, Vec tangent) {
            expect(work.w.size() == tangent.size(), "as many numbers as displacements");
            return turn(work, sign, orientation, tangent);
        },
        "work"_a, "sign"_a, "orientation"_a, "tangent"_a);
    m.def(
        "torn",
        [](const Work& work, double sign, double orientation, In q, In tangent, In trial, double step, double most) {
            for (const In& one : {q, tangent, trial}) {
                expect(one.size() == work.w.size(), "as many numbers as displacements");
            }
            return torn(work, sign, orientation, q, tangent, trial, step, most);
        },
        "work"_a, "sign"_a, "orientation"_a, "q"_a, "tangent"_a, "trial"_a, "step"_a, "most"_a);
    m.def(
        "fell_from_crest",
        [](const Elastic& model, Work& work, Stepper& stepper, const std::optional<Fronts>& fronts) {
            const Fronts* chosen = checked(model, work, stepper, fronts);
            Breath breath;
            return fell_from_crest(model, work, stepper, chosen, breath);
        },
        "model"_a, "work"_a, "stepper"_a, "fronts"_a.none(), nogil());
}

void bind_paths(nb::module_& m) {
    m.def(
        "follow_each",
        [](const Elastic& model, Work& work, Stepper& stepper, In start, InMat loads, const PathResult& into,
           InInts rows, In most, const std::optional<Fronts>& fronts) {
            const Fronts* chosen = checked(model, work, stepper, fronts);
            const Int count = loads.size();
            expect_displacement(model, start);
            expect_rows(model, loads, count);
            expect_result(model, into, count);
            expect(most.size() == count, "a number for each load");
            expect_indices(rows, count, "a known load");
            Breath breath;
            follow_each(model, work, stepper, start, loads, into, rows, most, chosen, breath);
        },
        "model"_a, "work"_a, "stepper"_a, "start"_a, "loads"_a, "into"_a, "rows"_a, "most"_a, "fronts"_a.none(),
        nogil());
    m.def(
        "loads_nearby",
        [](const Elastic& model, Work& work, InMat loads, In s, InMat q, InMat plane, Vec into, InInts rows,
           const std::optional<Fronts>& fronts) {
            const Fronts* chosen = checked(model, work, fronts);
            const Int count = loads.size();
            for (const InMat& one : {loads, q, plane}) expect_rows(model, one, count);
            expect(s.size() == count && into.size() == count, "a number for each load");
            expect_indices(rows, count, "a known load");
            Breath breath;
            loads_nearby(model, work, loads, s, q, plane, into, rows, chosen, breath);
        },
        "model"_a, "work"_a, "loads"_a, "s"_a, "q"_a, "plane"_a, "into"_a, "rows"_a, "fronts"_a.none(), nogil());
}

}  // namespace

void bind_walk(nb::module_& m) {
    bind_numbers(m);
    bind_progress(m);
    bind_newton(m);
    bind_resting(m);
    bind_steps(m);
    bind_paths(m);
}

}  // namespace holdfast
