// Python's global lock, released for a while and taken again, also by a thread that outlives Python.
//
// Threads that nobody waits for compute on while Python ends, after Ctrl-C for example. Up to Python 3.13 one that then
// asks for the lock is ended there and then, by unwinding its stack; frames of C++ that let nothing through would make
// that the end of the process, with an abort. So it sleeps instead, as it does in Python 3.14, until the process ends.

#pragma once

#include <nanobind/nanobind.h>

#include <chrono>
#include <thread>

namespace holdfast {

template <class Take>
auto take_lock(Take take) {
    try {
        return take();
    } catch (...) {
        while (true) std::this_thread::sleep_for(std::chrono::hours(1));
    }
}

// Without the lock as long as it lives, in a thread that has it
class Unlocked {
  public:
    Unlocked() : state_(PyEval_SaveThread()) {}
    Unlocked(const Unlocked&) = delete;
    Unlocked& operator=(const Unlocked&) = delete;
    ~Unlocked() {
        take_lock([this] { PyEval_RestoreThread(state_); });
    }

  private:
    PyThreadState* state_;
};

// With the lock as long as it lives, in any thread
class Locked {
  public:
    Locked() : state_(take_lock([] { return PyGILState_Ensure(); })) {}
    Locked(const Locked&) = delete;
    Locked& operator=(const Locked&) = delete;
    ~Locked() { PyGILState_Release(state_); }

  private:
    PyGILState_STATE state_;
};

}  // namespace holdfast
