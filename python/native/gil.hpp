#pragma once
// Holding and releasing the GIL, also while the interpreter ends.
//
// Python ends a thread that wants the GIL then by pthread_exit(), which unwinds it, and C++ ends
// the process when that meets a destructor or a catch (...). Such a thread stops here instead: the
// process is about to end.
//
// Threads: any.

#include <cxxabi.h>
#include <pybind11/pybind11.h>
#include <unistd.h>

namespace musher::python {

template <class Work>
auto StopAtInterpreterEnd(const Work& work) {
  try {
    return work();
  } catch (abi::__forced_unwind&) {
    while (true) pause();
  }
}

class TakenGil {
 public:
  TakenGil() : state_(StopAtInterpreterEnd([] { return PyGILState_Ensure(); })) {}
  ~TakenGil() { PyGILState_Release(state_); }
  TakenGil(const TakenGil&) = delete;
  TakenGil& operator=(const TakenGil&) = delete;

 private:
  const PyGILState_STATE state_;
};

class ReleasedGil {
 public:
  ReleasedGil() : state_(PyEval_SaveThread()) {}
  ~ReleasedGil() {
    StopAtInterpreterEnd([this] { PyEval_RestoreThread(state_); });
  }
  ReleasedGil(const ReleasedGil&) = delete;
  ReleasedGil& operator=(const ReleasedGil&) = delete;

 private:
  PyThreadState* const state_;
};

// Calls Python from a thread of Musher, which holds the GIL. Null with Python's error set.
inline PyObject* CallPython(PyObject* function, PyObject* arguments) {
  return StopAtInterpreterEnd([&] { return PyObject_Call(function, arguments, nullptr); });
}

// Runs `work`, which may wait, without the GIL; returns its result.
template <class Work>
auto WithoutGil(const Work& work) {
  const ReleasedGil released;
  return work();
}

}  // namespace musher::python
