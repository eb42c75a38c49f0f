// The Python extension `musher._native`.

#include "musher/base/version.hpp"
#include "musher/python/native/client.hpp"
#include "musher/python/native/codec.hpp"
#include "musher/python/native/fault_test.hpp"
#include "musher/python/native/fsm_machine.hpp"
#include "musher/python/native/node.hpp"
#include "musher/python/native/parts.hpp"

namespace musher::python {

void Raise(const char* name, const Error& error) {
  const py::object type = py::module_::import("musher._errors").attr(name);
  const py::object value = type(error.code, error.message);
  PyErr_SetObject(type.ptr(), value.ptr());
  throw py::error_already_set();
}

void Check(const Result<>& result, const char* name) {
  if (!result) Raise(name, result.error());
}

}  // namespace musher::python

PYBIND11_MODULE(_native, native) {
  native.attr("VERSION") = std::string(musher::Version());
  musher::python::AddCodec(native);
  musher::python::AddNode(native);
  musher::python::AddServices(native);
  musher::python::AddActions(native);
  musher::python::AddClient(native);
  musher::python::AddActuator(native);
  musher::python::AddFsm(native);
  musher::python::AddFsmTicks(native);
  musher::python::AddFaultTest(native);
}
