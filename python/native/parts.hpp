#pragma once
// The parts of the Python extension `musher._native`, each in a source of its own, and what they
// share.
//
// Python's global interpreter lock (GIL) and Musher's threads:
//   - The loop's thread never takes the GIL. What it receives goes into a mailbox (mailbox.hpp);
//     a Python thread takes it from there.
//   - Calls of Python into Musher release the GIL before they wait for the loop or another thread.
//   - State callbacks run on the actuator's worker, OnEmergencyStop() on a thread of its own; both
//     take the GIL.
//   - No Python exception passes through Musher: the Python layer catches it and returns a reason.

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>  // in each source: the conversions of a type are the same in all

#include <string>
#include <utility>

#include "musher/base/result.hpp"
#include "musher/lifecycle/state.hpp"
#include "musher/python/native/gil.hpp"

namespace musher::python {

namespace py = pybind11;

void AddActuator(py::module_& native);

// Raises musher.<name>(code, reason). With the GIL.
[[noreturn]] void Raise(const char* name, const Error& error);
// Raises musher.Failure unless `result` is good.
void Check(const Result<>& result, const char* name = "Failure");

}  // namespace musher::python

namespace pybind11::detail {

// A state is a str in Python.
template <>
struct type_caster<musher::State> {
  PYBIND11_TYPE_CASTER(musher::State, const_name("str"));

  bool load(handle source, bool convert) {
    make_caster<std::string> name;
    if (!name.load(source, convert)) return false;
    value = musher::State(cast_op<std::string&&>(std::move(name)));
    return true;
  }
  static handle cast(const musher::State& state, return_value_policy policy, handle parent) {
    return make_caster<std::string>::cast(state.name(), policy, parent);
  }
};

}  // namespace pybind11::detail
