#pragma once
// Python: the fault-injection test of an actuator in virtual time (simulation/fault_test.hpp).

#include "musher/python/native/parts.hpp"

namespace musher::python {

void AddFaultTest(py::module_& native);

}  // namespace musher::python
