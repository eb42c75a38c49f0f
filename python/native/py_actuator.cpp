#include "musher/python/native/py_actuator.hpp"

#include <stdexcept>
#include <utility>

#include "musher/base/code.hpp"

namespace musher::python {
namespace {

py::object Call(const py::object& function, const py::tuple& arguments) {
  auto result = py::reinterpret_steal<py::object>(CallPython(function.ptr(), arguments.ptr()));
  if (!result) throw py::error_already_set();
  return result;
}

}  // namespace

PyActuator& ActuatorHandle::Get() const {
  if (actuator == nullptr) {
    Raise("Failure",
          {kCodeStateInvalid, "this actuator has ended: its process was killed by the test"});
  }
  if (left_to_parent) {
    Raise("Failure", {kCodeStateInvalid,
                      actuator->name() + " runs in the process that this one is a fork of: make "
                                         "a node or a Machine of its own here"});
  }
  return *actuator;
}

ActuatorHandle::~ActuatorHandle() {
  if (owned && !left_to_parent)  // its end waits for threads that a fork does not have
    delete actuator;  // NOLINT(cppcoreguidelines-owning-memory): pybind11's holder is the handle
}

PyActuator::PyActuator(const std::string& name, const py::object& self, ActuatorHandle& handle)
    : MachineActuator(name), self_(self), handle_(&handle) {
  handle.actuator = this;
}

PyActuator::~PyActuator() {
  if (PyGILState_Check() != 0) {
    WithoutGil([this] { End(); });
  } else {
    End();
  }
  const TakenGil gil;
  handle_->actuator = nullptr;
  self_ = py::weakref();
  kept_ = py::object();
}

void PyActuator::Register(const State& state, const std::string& method) {
  if (state.empty()) {
    RegisterStateCallback(
        [this, method](const State& which) { return RunCallback(method, which); });
  } else {
    RegisterStateCallback(state, [this, method, state] { return RunCallback(method, state); });
  }
}

Result<> PyActuator::StartWithStopThread() {
  stop_thread_.emplace(WorkQueueOptions{.name = "emergency-stop"});
  return Start();
}

void PyActuator::End() {
  Shutdown();
  stop_thread_.reset();
}

std::unique_ptr<PyActuator> PyActuator::Release() {
  kept_ = Self();
  handle_->owned = false;
  return std::unique_ptr<PyActuator>(this);
}

py::object PyActuator::Self() const {
  return self_();
}

void PyActuator::OnEmergencyStop() {
  if (stop_thread_) {
    const std::lock_guard lock(stops_mutex_);
    const std::uint64_t number = ++stops_;
    ReportStopTrouble("on_emergency_stop has not ended");
    const auto stop = [this, number] {
      const std::string raised = CallStop();
      if (!raised.empty()) Log(LogLevel::kError, "on_emergency_stop raised " + raised);
      const std::lock_guard ended(stops_mutex_);
      if (number != stops_) return;  // it runs again
      ReportStopTrouble(raised.empty() ? "" : "on_emergency_stop raised " + raised);
    };
    stop_thread_->Do(stop, {.key = "stop"});
    return;
  }
  if (const std::string raised = CallStop(); !raised.empty()) throw std::runtime_error(raised);
}

std::string PyActuator::CallStop() {
  const TakenGil gil;
  const py::object self = Self();
  if (self.is_none()) return {};
  try {
    return Call(self.attr("_run_emergency_stop"), py::tuple()).cast<std::string>();
  } catch (const std::exception& e) {
    return e.what();
  }
}

Result<> PyActuator::RunCallback(const std::string& method, const State& state) {
  const TakenGil gil;
  const py::object self = Self();
  if (self.is_none())
    return Error{kCodeFailed, "the Python object of " + name() + " was collected"};
  try {
    const py::object failed = Call(self.attr("_run_callback"), py::make_tuple(method, state));
    if (failed.is_none()) return Ok();
    const auto [code, reason] = failed.cast<std::pair<std::int32_t, std::string>>();
    return Error{code, reason};
  } catch (const std::exception& e) {  // of the Python layer itself
    return Error{kCodeFailed, e.what()};
  }
}

}  // namespace musher::python
