// Ctrl-C in calls that may take long: they draw breath now and then, and let Python's handlers of signals act.

#pragma once

#include <nanobind/nanobind.h>

#include <chrono>

#include "lock.hpp"

namespace holdfast {

// Made for one call, which has released Python's global lock, and asked once a step of Newton's method
class Breath {
  public:
    // Throws what a handler of a signal has raised
    void take() {
        if (!listens_ || Clock::now() < next_) return;
        listen();
        next_ = Clock::now() + OFTEN;
    }

  private:
    using Clock = std::chrono::steady_clock;
    static constexpr std::chrono::milliseconds OFTEN{50};  // a fourth of how long a user may have to wait

    // Handlers act in the main thread alone: others do not ask again, and leave the lock to those that need it
    void listen() {
        const Locked lock;
        const nanobind::module_ threading = nanobind::module_::import_("threading");
        listens_ = threading.attr("get_ident")().equal(threading.attr("main_thread")().attr("ident"));
        if (listens_ && PyErr_CheckSignals() != 0) throw nanobind::python_error();
    }

    bool listens_ = true;
    Clock::time_point next_ = Clock::now() + OFTEN;
};

}  // namespace holdfast
