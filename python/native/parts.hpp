#pragma once
// The parts of the Python extension `musher._native`, each in a source of its own, and what they
// share.
//
// Python's global interpreter lock (GIL) and Musher's threads:
//   - The loop's thread never takes the GIL. What it receives goes into a mailbox (mailbox.hpp),
//   from
//     which a Python thread takes it.
//   - Calls of Python into Musher release the GIL before they wait for the loop or another thread.
//   - State callbacks run on the actuator's worker, OnEmergencyStop() on a thread of its own; both
//     take the GIL.
//   - No Python exception passes through Musher: the Python layer catches it and returns a reason.

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>  // in each source: the conversions of a type are the same in all

#include <string>

#include "musher/base/result.hpp"
#include "musher/python/native/gil.hpp"

namespace musher::python {

namespace py = pybind11;

void AddActuator(py::module_& native);

// Raises musher.<name>(code, reason). With the GIL.
[[noreturn]] void Raise(const char* name, const Error& error);
// Raises musher.Failure unless `result` is good.
void Check(const Result<>& result, const char* name = "Failure");

}  // namespace musher::python
