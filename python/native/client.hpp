#pragma once
// Python: the clients of a machine that `musher` uses, see controller/client/.

#include "musher/python/native/parts.hpp"

namespace musher::python {

void AddClient(py::module_& native);

}  // namespace musher::python
