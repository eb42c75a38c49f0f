// Python: state machines (musher/fsm.py).

#include "musher/application/behavior_report.hpp"
#include "musher/base/code.hpp"
#include "musher/behavior/fsm/graph.hpp"
#include "musher/messages/cdr.hpp"
#include "musher/python/native/fsm_machine.hpp"
#include "musher/python/native/node.hpp"

namespace musher::python {
namespace {

std::string Text(std::string_view text) {
  return std::string(text);
}

Time At(std::int64_t ns) {
  return Time(std::clamp(Duration(ns), Duration(-kFarthestNs), Duration(kFarthestNs)));
}

fsm::Into IntoOf(int into) {
  constexpr std::array kInto{fsm::Into::kStart, fsm::Into::kHistory, fsm::Into::kDeepHistory};
  return kInto.at(static_cast<std::size_t>(into));
}

FsmNext To(const std::string& state, double gradually_s, int into) {
  if (state.empty()) throw py::value_error("the name of a state is expected");
  return {state, Seconds(gradually_s), FsmNext::Use::kHandled, IntoOf(into)};
}

FsmNext KeepCommand(FsmNext next) {
  next.use = FsmNext::Use::kKept;
  return next;
}

std::shared_ptr<FsmMachine> MakeMachine(const std::string& name, std::size_t history,
                                        std::size_t commands, std::size_t commands_per_tick,
                                        double longest_transition_s) {
  return std::make_shared<FsmMachine>(fsm::Machine::Options{
      name, history, commands, commands_per_tick, Seconds(longest_transition_s)});
}

// `inside`: a list of a machine and the name of its start state.
void AddNested(FsmMachine& self, const std::string& name, int role, const py::tuple& hooks,
               const py::list& inside, fsm::Nested::Options options) {
  std::vector<FsmMachine::Inside> machines;
  for (const py::handle one : inside) {
    const auto pair = one.cast<std::pair<std::shared_ptr<FsmMachine>, std::string>>();
    machines.push_back({pair.first, pair.second});
  }
  self.AddNested(name, role, hooks, machines, std::move(options));
}

std::vector<py::object> History(const FsmMachine& machine) {
  const fsm::History& history = machine.machine().history();
  std::vector<py::object> changes;
  for (std::size_t i = 0; i < history.size(); ++i) {
    changes.push_back(MakeChange(machine.machine(), history[i]));
  }
  return changes;
}

std::map<std::string, std::uint64_t> Counts(const FsmMachine& machine) {
  const fsm::Counts& counts = machine.machine().counts();
  return {{"changes", counts.changes},       {"unhandled", counts.unhandled},
          {"superseded", counts.superseded}, {"refused", counts.refused},
          {"faults", counts.faults},         {"listener_faults", counts.listener_faults}};
}

std::vector<std::string> Commands(const FsmMachine& machine) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < machine.machine().event_count(); ++i) {
    names.push_back(Text(machine.machine().Name(static_cast<fsm::EventId>(i))));
  }
  return names;
}

std::string Picture(const FsmMachine& machine, const std::string& format) {
  const fsm::Machine& built = machine.machine();
  if (format == "dot") return fsm::ToDot(built.chart(), built.Path());
  if (format == "mermaid") return fsm::ToMermaid(built.chart(), built.Path());
  throw py::value_error("the format of a picture is \"dot\" or \"mermaid\", not \"" + format +
                        "\"");
}

// The response of get_behavior, encoded.
py::bytes Report(const FsmMachine& machine, bool ticking, std::uint32_t history,
                 const std::string& format) {
  msg::GetBehavior::Request request;
  request.history = history;
  request.format = format;
  const msg::Bytes bytes = msg::Encode(ReportBehavior(machine.machine(), ticking, request));
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// The safe state; empty: none.
std::string SafeState(const FsmMachine& machine) {
  for (const auto& state : machine.machine().chart().states) {
    if (state.role == fsm::Role::kSafe) return state.name;
  }
  return {};
}

bool IsConstructed(PyObject* self) {
  return reinterpret_cast<py::detail::instance*>(self)->get_value_and_holder().holder_constructed();
}

void CollectGarbage(PyHeapTypeObject* heap) {
  PyTypeObject& type = heap->ht_type;
  type.tp_flags |= Py_TPFLAGS_HAVE_GC;
  type.tp_traverse = [](PyObject* self, visitproc visit, void* arg) {
    Py_VISIT(Py_TYPE(self));
    return IsConstructed(self) ? py::cast<const FsmMachine&>(py::handle(self)).Visit(visit, arg)
                               : 0;
  };
  type.tp_clear = [](PyObject* self) {
    if (IsConstructed(self)) py::cast<FsmMachine&>(py::handle(self)).Clear();
    return 0;
  };
}

void AddValues(py::module_& native) {
  py::class_<FsmTick>(native, "FsmTick")
      .def_property_readonly("now_s", [](const FsmTick& t) { return ToSeconds(t.tick.now); })
      .def_property_readonly("step_s", [](const FsmTick& t) { return ToSeconds(t.tick.step); })
      .def_property_readonly("elapsed_s",
                             [](const FsmTick& t) { return ToSeconds(t.tick.elapsed); })
      .def_readonly("command", &FsmTick::command)
      .def_readonly("data", &FsmTick::data)
      .def_readonly("target", &FsmTick::target)
      .def_property_readonly("transition_elapsed_s",
                             [](const FsmTick& t) { return ToSeconds(t.tick.transition_elapsed); })
      .def_property_readonly("transition_time_s",
                             [](const FsmTick& t) { return ToSeconds(t.tick.transition_time); })
      .def_property_readonly("progress", [](const FsmTick& t) { return t.tick.progress(); });
  py::class_<FsmNext>(native, "FsmNext")
      .def_static("stay", [] { return FsmNext{}; })
      .def_static("handle",
                  [] {
                    return FsmNext{{}, {}, FsmNext::Use::kHandled};
                  })
      .def_static("to", &To, py::arg("state"), py::kw_only(), py::arg("gradually_s") = 0.0,
                  py::arg("into") = 0)
      .def("keep_command", &KeepCommand);
  py::class_<FsmTransitions>(native, "FsmTransitions")
      .def(
          "to",
          [](const FsmTransitions& t, const std::string& state, const std::string& when, int into) {
            t.Get();
            t.To(state, when, IntoOf(into));
          },
          py::arg("state"), py::arg("when"), py::kw_only(), py::arg("into") = 0)
      .def("defer", [](const FsmTransitions& t, const std::string& event) { t.Get().Defer(event); })
      .def("on", [](const FsmTransitions& t, const std::string& event) { t.Get().On(event); })
      .def("find", [](const FsmTransitions& t,
                      const std::string& event) { return t.Get().Find(event).has_value(); })
      .def("refuse", [](const FsmTransitions& t, const std::string& why) { t.Get().Refuse(why); });
  py::class_<FsmArchive>(native, "FsmArchive")
      .def("field", &FsmArchive::Field)
      .def("duration_s", &FsmArchive::FieldOfSeconds);
  py::class_<FsmChange>(native, "FsmChange")
      .def_readonly("at_s", &FsmChange::at_s)
      .def_readonly("tick", &FsmChange::tick)
      .def_readonly("from_state", &FsmChange::from)
      .def_readonly("to_state", &FsmChange::to)
      .def_readonly("cause", &FsmChange::cause)
      .def_readonly("command", &FsmChange::command)
      .def("__repr__", [](const FsmChange& change) {
        return "Change(" + std::to_string(change.at_s) + " s: " + change.from + " -> " + change.to +
               ", " + change.cause + (change.command.empty() ? "" : " by " + change.command) + ")";
      });
}

using FsmMachineClass = py::class_<FsmMachine, std::shared_ptr<FsmMachine>>;

// What builds and runs it.
void AddCommands(FsmMachineClass& machine_class) {
  using Self = FsmMachine;
  using Machine = fsm::Machine;
  machine_class.def(py::init(&MakeMachine))
      .def("add", &Self::Add)
      .def("add_nested",
           [](Self& self, const std::string& name, int role, const py::tuple& hooks,
              const py::list& inside, const std::string& finished, bool resumes, bool inner_first) {
             AddNested(self, name, role, hooks, inside, {finished, resumes, inner_first});
           })
      .def("add_event", &Self::AddEvent)
      .def("add_safety_check", &Self::AddSafetyCheck)
      .def("add_data", &Self::AddData)
      .def("build", &Self::Build)
      .def("built", &Self::built)
      .def("warnings", [](const Self& self) { return self.machine().warnings(); })
      .def("start",
           [](Self& self, std::int64_t ns, const std::string& state) {
             self.Change([&](Machine& machine) -> Result<> {
               if (state.empty()) return machine.Start(At(ns));
               const auto at = machine.FindState(state);
               if (!at) return Error{kCodeFailed, machine.name() + ": there is no state " + state};
               return machine.StartAt(*at, At(ns));
             });
           })
      .def("run_once",
           [](Self& self, std::int64_t ns) {
             self.Change([&](Machine& machine) { machine.RunOnce(At(ns)); });
           })
      .def("pause", [](Self& self) { self.Change([](Machine& machine) { machine.Pause(); }); })
      .def("stop", [](Self& self) { self.Change([](Machine& machine) { return machine.Stop(); }); })
      .def("send", &Self::Send)
      .def("force",
           [](Self& self, const std::string& state) {
             self.Change([&](Machine& machine) { return machine.Force(state); });
           })
      .def("reset",
           [](Self& self) { self.Change([](Machine& machine) { return machine.Reset(); }); })
      .def("listen", &Self::Listen)
      .def("record", &Self::Record)
      .def("record_input", &Self::RecordInput)
      .def("replay",
           [](Self& self, const std::string& recording, const std::string& file,
              const py::object& apply) {
             const fsm::Replayed replayed = self.Replay(recording, file, apply);
             return py::make_tuple(replayed.ticks, replayed.changes, replayed.difference);
           })
      .def("save", &Self::Save)
      .def("restore", [](Self& self, const std::string& text, const std::string& file,
                         std::int64_t ns) { self.Restore(text, file, At(ns)); })
      .def("report_exceptions", &Self::ReportExceptions);
}

void AddQueries(FsmMachineClass& machine_class) {
  using Self = FsmMachine;
  machine_class.def("name", [](const Self& self) { return self.machine().name(); })
      .def("running", [](const Self& self) { return self.machine().running(); })
      .def("mode", [](const Self& self) { return Text(fsm::Name(self.machine().mode())); })
      .def("path", [](const Self& self) { return self.machine().Path(); })
      .def("state",
           [](const Self& self) { return Text(self.machine().Name(self.machine().current())); })
      .def("safe_state", &SafeState)
      .def("ticks", [](const Self& self) { return self.machine().ticks(); })
      .def("time_s", [](const Self& self) { return ToSeconds(self.machine().time()); })
      .def("elapsed_s", [](const Self& self) { return ToSeconds(self.machine().elapsed()); })
      .def("unsafe", [](const Self& self) { return Text(self.machine().unsafe()); })
      .def("fault",
           [](const Self& self) {
             const auto& fault = self.machine().fault();
             return fault ? self.machine().Describe(*fault) : std::string();
           })
      .def("waiting_commands", [](const Self& self) { return self.machine().waiting_commands(); })
      .def("history", &History)
      .def("counts", &Counts)
      .def("commands", &Commands)
      .def("picture", &Picture)
      .def("report", &Report);
}

}  // namespace

py::object MakeChange(const fsm::Machine& machine, const fsm::Change& change) {
  return py::cast(FsmChange{ToSeconds(change.at), change.tick, Text(machine.Name(change.from)),
                            Text(machine.Name(change.to)), Text(fsm::Name(change.cause)),
                            Text(machine.Name(change.command))});
}

void AddFsm(py::module_& native) {
  AddValues(native);
  FsmMachineClass machine_class(native, "FsmMachine", py::custom_type_setup(&CollectGarbage));
  AddCommands(machine_class);
  AddQueries(machine_class);
}

}  // namespace musher::python
