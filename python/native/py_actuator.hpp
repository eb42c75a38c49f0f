#pragma once
// An actuator whose callbacks are methods of a Python object (musher/_actuator.py).
//
//   Python's Actuator ──its handle──▶ PyActuator ──weak reference──▶ Python's Actuator
//
// Python owns the handle, and the handle owns the PyActuator until a fault-injection test takes it
// (Release()); then the PyActuator owns the Python object, and the handle is empty once it is
// destroyed.
//
// Threads: the constructor, the destructor and Release() with the GIL or, for the destructor,
// without; the callbacks take it.

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/base/work_queue.hpp"
#include "musher/python/native/parts.hpp"

namespace musher::python {

class PyActuator;

struct ActuatorHandle {
  ~ActuatorHandle();
  PyActuator* actuator = nullptr;
  bool owned = true;
  bool left_to_parent = false;  // this process is a fork of the one that runs it

  // Raises musher.Failure if the actuator's process has ended, and in a fork of it.
  PyActuator& Get() const;
};

class PyActuator final : public MachineActuator {
 public:
  // `self`: the Python object; weakly referenced.
  PyActuator(const std::string& name, const py::object& self, ActuatorHandle& handle);
  ~PyActuator() override;

  // `method` of the Python object is the callback of `state`, or with an empty state of all states
  // without one of their own.
  void Register(const State& state, const std::string& method);
  // Starts with an emergency stop that runs on a thread of its own: the loop, which receives the
  // stop, must not wait for the GIL.
  Result<> StartWithStopThread();
  void End();  // idempotent; without the GIL
  using MachineActuator::LeaveToParent;

  // Passes the ownership of this object to the caller.
  std::unique_ptr<PyActuator> Release();
  // The Python object; none if it was collected. With the GIL.
  py::object Self() const;

 protected:
  void OnEmergencyStop() override;

 private:
  Result<> RunCallback(const std::string& method, const State& state);
  // Returns what the Python function raised; empty: nothing.
  std::string CallStop();

  py::weakref self_;
  py::object kept_;  // of a test's actuator: what self_ refers to
  ActuatorHandle* handle_;
  std::optional<WorkQueue> stop_thread_;
  std::mutex stops_mutex_;   // guards the one below, together with what is reported of it
  std::uint64_t stops_ = 0;  // so many were engaged
};

}  // namespace musher::python
