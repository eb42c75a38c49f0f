// Python: the handle of an actuator.

#include "musher/base/code.hpp"
#include "musher/base/log.hpp"
#include "musher/cyberdog/codes/module_codes.hpp"  // names modules in texts
#include "musher/python/native/node.hpp"
#include "musher/python/native/py_actuator.hpp"

namespace musher::python {
namespace {

// Thrown by a fault-injection test out of StopRequested(): the process is killed. In Python it is
// no Exception, so that `except Exception` does not keep the callback running.
bool StopRequested(const ActuatorHandle& handle) {
  const PyActuator& actuator = handle.Get();
  bool killed = false;
  const bool requested = WithoutGil([&] {
    try {
      return actuator.StopRequested();
    } catch (...) {
      killed = true;
      return true;
    }
  });
  if (killed) Raise("ProcessKilled", {kCodeFailed, "the test kills the process"});
  return requested;
}

Error CheckedError(std::int32_t code, const std::string& reason) {
  if (code == kCodeOk) {
    Raise("Failure", {kCodeParametersInvalid, "code 0 means success; give a failure another code"});
  }
  return {code, reason};
}

int Wait(ActuatorHandle& handle) {
  PyActuator& actuator = handle.Get();
  return WithoutGil([&] {
    const int code = actuator.Wait();
    actuator.End();
    return code;
  });
}

std::vector<State> ListedStates(const ActuatorHandle& handle) {
  const PyActuator& actuator = handle.Get();
  const MachineConfig& config = actuator.machine_config();
  const ActuatorConfig& own = config.actuators[*config.IndexOf(actuator.name())];
  return own.states;
}

void Checkpoint(const ActuatorHandle& handle, std::optional<double> allowance_s) {
  PyActuator& actuator = handle.Get();
  if (!allowance_s) return actuator.Checkpoint();
  constexpr double kMost = 1e9;  // s
  if (!(*allowance_s > 0)) throw py::value_error("a checkpoint's allowance is a time above 0 s");
  actuator.Checkpoint(*allowance_s > kMost ? MachineActuator::kNoMore
                                           : std::chrono::nanoseconds(
                                                 static_cast<std::int64_t>(*allowance_s * 1e9)));
}

std::string ConfigFile(const ActuatorHandle& handle) {
  return handle.Get().machine_config().file;
}

// None in a fault-injection test, and before start() and after shutdown().
PyNodePtr NodeOf(const ActuatorHandle& handle) {
  const PyActuator& actuator = handle.Get();
  auto thread = actuator.node();
  if (!thread) return nullptr;
  const auto node =
      std::make_shared<PyNode>(std::move(thread), actuator.machine_config().name_space);
  WithoutGil([&] {
    node->thread->RunOnLoop(
        [&] { node->breaks = std::make_unique<transport::LoopBreaks>(node->thread->loop()); });
  });
  return node;
}

void ReportFault(const ActuatorHandle& handle, std::int32_t code, const std::string& message) {
  PyActuator& actuator = handle.Get();
  WithoutGil([&] { actuator.RunOnLoop([&] { actuator.ReportFault({code, message}); }); });
}

std::unique_ptr<ActuatorHandle> MakeHandle(const std::string& name, const py::object& self) {
  auto handle = std::make_unique<ActuatorHandle>();
  // The handle owns it, see py_actuator.hpp.
  static_cast<void>(
      new PyActuator(name, self, *handle));  // NOLINT(cppcoreguidelines-owning-memory)
  return handle;
}

void Log(int level, const std::string& name, const std::string& text) {
  WithoutGil([&] { WriteLog(static_cast<LogLevel>(level), name, text); });
}

}  // namespace

void AddActuator(py::module_& native) {
  native.def("write_log", &Log);
  native.def("lowest_log_level", [] { return static_cast<int>(LowestLogLevel()); });
  native.def("code_text", &CodeText);
  py::class_<ActuatorHandle>(native, "ActuatorHandle")
      .def(py::init(&MakeHandle))
      .def("name", [](const ActuatorHandle& h) { return h.Get().name(); })
      .def("register", [](ActuatorHandle& h, const State& state,
                          const std::string& method) { h.Get().Register(state, method); })
      .def("init",
           [](ActuatorHandle& h, const std::string& file) {
             PyActuator& actuator = h.Get();
             Check(WithoutGil([&] { return actuator.Init(file); }), "ConfigError");
           })
      .def("check",
           [](ActuatorHandle& h, const std::string& file) {
             PyActuator& actuator = h.Get();
             return WithoutGil([&] { return actuator.Check(file); });
           })
      .def("start",
           [](ActuatorHandle& h) {
             PyActuator& actuator = h.Get();
             Check(WithoutGil([&] { return actuator.StartWithStopThread(); }));
           })
      .def("wait", &Wait)
      .def("shutdown",
           [](ActuatorHandle& h) {
             PyActuator& actuator = h.Get();
             WithoutGil([&] { actuator.End(); });
           })
      .def("leave_to_parent",
           [](ActuatorHandle& h) {
             h.Get().LeaveToParent();
             h.left_to_parent = true;
           })
      .def("give_up", [](ActuatorHandle& h, std::int32_t code,
                         const std::string& why) { h.Get().GiveUp(CheckedError(code, why)); })
      .def("stop_requested", &StopRequested)
      .def("checkpoint", &Checkpoint)
      .def("current_state", [](const ActuatorHandle& h) { return h.Get().CurrentState(); })
      .def("allowed",
           [](const ActuatorHandle& h, const std::string& capability, std::int32_t module) {
             Check(h.Get().Allowed(capability, static_cast<ModuleCode>(module)), "NotAllowed");
           })
      .def("report_degraded",
           [](ActuatorHandle& h, std::int32_t code, const std::string& why) {
             h.Get().ReportDegraded(CheckedError(code, why));
           })
      .def("report_fault", &ReportFault)
      .def("emergency_stopped", [](const ActuatorHandle& h) { return h.Get().EmergencyStopped(); })
      .def("held_by_stop", [](const ActuatorHandle& h) { return h.Get().HeldByStop(); })
      .def("listed_states", &ListedStates)
      .def("config_file", &ConfigFile)
      .def("node", &NodeOf)
      .def("under_test", [](const ActuatorHandle& h) { return !h.owned; });
}

}  // namespace musher::python
