#include "musher/python/native/fsm_machine.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "musher/base/code.hpp"
#include "musher/behavior/fsm/recorder.hpp"
#include "musher/behavior/fsm/toml/snapshot_toml.hpp"

namespace musher::python {
namespace {

fsm::Role RoleOf(int role) {
  constexpr std::array kRoles{fsm::Role::kNormal, fsm::Role::kSafe, fsm::Role::kFinal};
  return kRoles.at(static_cast<std::size_t>(role));
}

}  // namespace

class FsmMachine::PyListener final : public fsm::Listener {
 public:
  PyListener(std::shared_ptr<PythonErrors> errors, py::object changed, py::object unhandled,
             py::object failed, py::object kept)
      : errors_(std::move(errors)),
        changed_(std::move(changed)),
        unhandled_(std::move(unhandled)),
        failed_(std::move(failed)),
        kept_(std::move(kept)) {}

  void OnChange(const fsm::Machine& machine, const fsm::Change& change) override {
    if (!changed_.is_none()) errors_->Call(changed_, MakeChange(machine, change));
  }
  void OnUnhandled(const fsm::Machine& machine, fsm::EventId command, fsm::StateId state) override {
    if (unhandled_.is_none()) return;
    errors_->Call(unhandled_, py::make_tuple(std::string(machine.Name(command)),
                                             std::string(machine.Name(state))));
  }
  void OnKept(const fsm::Machine& machine, fsm::EventId command, fsm::StateId state) override {
    if (kept_.is_none()) return;
    errors_->Call(kept_, py::make_tuple(std::string(machine.Name(command)),
                                        std::string(machine.Name(state))));
  }
  void OnFault(const fsm::Machine& machine, const fsm::Fault& fault) override {
    if (!failed_.is_none()) errors_->Call(failed_, py::str(machine.Describe(fault)));
  }
  int Visit(visitproc visit, void* arg) const {
    Py_VISIT(changed_.ptr());
    Py_VISIT(unhandled_.ptr());
    Py_VISIT(failed_.ptr());
    Py_VISIT(kept_.ptr());
    return 0;
  }

 private:
  const std::shared_ptr<PythonErrors> errors_;
  const py::object changed_;
  const py::object unhandled_;
  const py::object failed_;
  const py::object kept_;
};

class FsmMachine::PyRecorder {
 public:
  PyRecorder(fsm::Machine& machine, const std::shared_ptr<PythonErrors>& errors, py::object write)
      : write_(std::move(write)), recorder_(machine, [this, errors](std::string_view line) {
          errors->Call(write_, py::str(line.data(), line.size()));
        }) {}

  fsm::Recorder& recorder() { return recorder_; }
  int Visit(visitproc visit, void* arg) const {
    Py_VISIT(write_.ptr());
    return 0;
  }

 private:
  const py::object write_;
  fsm::Recorder recorder_;
};

FsmMachine::FsmMachine(fsm::Machine::Options options)
    : owned_(std::make_unique<fsm::Machine>(std::move(options))), machine_(owned_.get()) {}

FsmMachine::~FsmMachine() {
  Clear();
}

void FsmMachine::Add(const std::string& name, int role, const py::tuple& hooks) {
  fsm::Machine& machine = Unbuilt();
  auto calls = CallsOf(hooks);
  machine.Add(name, std::make_unique<PyState>(std::move(calls)), RoleOf(role));
}

void FsmMachine::AddNested(const std::string& name, int role, const py::tuple& hooks,
                           const std::vector<Inside>& inside, fsm::Nested::Options options) {
  fsm::Machine& machine = Unbuilt();
  for (const Inside& one : inside) {
    if (one.machine.get() == this) throw py::value_error("a machine cannot be inside itself");
    one.machine->Unbuilt();
    if (std::ranges::count(inside, one.machine, &Inside::machine) > 1) {
      throw py::value_error("a state holds a machine once");
    }
  }
  auto calls = CallsOf(hooks);
  std::vector<fsm::Nested::Region> regions;
  for (const Inside& one : inside) {
    regions.push_back({std::move(one.machine->owned_), one.start});
    inside_.push_back(one.machine);
  }
  machine.Add(name,
              std::make_unique<PyNested>(std::move(calls), std::move(regions), std::move(options)),
              RoleOf(role));
}

void FsmMachine::AddEvent(const std::string& name, bool urgent, const py::object& data_class) {
  fsm::Machine& machine = Unbuilt();
  const fsm::EventType* const type =
      data_class.is_none() ? nullptr : PyEventType::Of(data_class).type();
  machine.AddEvent(name, urgent ? fsm::Urgency::kUrgent : fsm::Urgency::kNormal, type);
}

void FsmMachine::Send(const std::string& command, const py::object& data) {
  Change([&](fsm::Machine& machine) {
    const auto event = machine.FindEvent(command);
    const auto expected =
        std::dynamic_pointer_cast<PyEventData>(event ? machine.NewData(*event) : nullptr);
    if (data.is_none()) return machine.Send(command);
    if (!expected) {
      throw py::type_error("the command " + command + " carries no data");
    }
    expected->py_type().Check(data);
    return machine.SendData(*event, std::make_shared<PyEventData>(expected->py_type(), data));
  });
}

void FsmMachine::AddSafetyCheck(const std::string& name, const py::object& is_safe) {
  fsm::Machine& machine = Unbuilt();
  auto function = std::make_shared<py::object>(is_safe);
  functions_.push_back(function);
  machine.AddSafetyCheck(name, [&machine, function, errors = errors_](const fsm::Tick& tick) {
    const py::object safe = errors->Call(*function, MakeTick(machine, tick));
    if (py::isinstance<py::bool_>(safe)) return safe.cast<bool>();
    throw std::runtime_error("it returned a " +
                             py::type::of(safe).attr("__name__").cast<std::string>() +
                             ", not whether it is safe");
  });
}

void FsmMachine::AddData(const std::string& name, const py::object& persist) {
  fsm::Machine& machine = Unbuilt();
  auto function = std::make_shared<py::object>(persist);
  functions_.push_back(function);
  machine.AddData(name, [function, errors = errors_](fsm::Archive& archive) {
    CallPersist(*errors, *function, archive);
  });
}

void FsmMachine::Build(const std::string& start) {
  const Result<> result = Unbuilt().Build(start);
  errors_->RaiseKept();
  Check(result);
  built_ = true;
}

const fsm::Machine& FsmMachine::machine() const {
  if (machine_ == nullptr) {
    Raise("Failure", {kCodeStateInvalid, "the machine around this one has ended"});
  }
  return *machine_;
}

void FsmMachine::Listen(const py::object& changed, const py::object& unhandled,
                        const py::object& failed, const py::object& kept) {
  static_cast<void>(machine());
  listeners_.push_back(std::make_unique<PyListener>(errors_, changed, unhandled, failed, kept));
  machine_->Listen(listeners_.back().get());
}

void FsmMachine::Record(const py::object& write) {
  fsm::Machine& machine = Own();
  const std::string why = !built_             ? "build() comes first"
                          : recorder_         ? "is recorded already"
                          : machine.running() ? "runs already: a recording begins with its start"
                                              : "";
  if (!why.empty()) Raise("Failure", {kCodeStateInvalid, machine.name() + ": " + why});
  recorder_ = std::make_unique<PyRecorder>(machine, errors_, write);
  errors_->RaiseKept();
}

void FsmMachine::RecordInput(const std::string& name, const std::string& text) {
  if (!recorder_) {
    Raise("Failure", {kCodeStateInvalid, machine().name() + ": record() comes first"});
  }
  recorder_->recorder().Input(name, text);
  errors_->RaiseKept();
}

fsm::Replayed FsmMachine::Replay(const std::string& recording, const std::string& file,
                                 const py::object& apply) {
  fsm::Replayed replayed;
  Change([&](fsm::Machine& machine) -> Result<> {
    if (machine.running()) {
      return Error{kCodeStateInvalid, machine.name() + ": runs already: a replay starts it"};
    }
    const Result<fsm::Recording> read = fsm::ReadRecording(recording, file);
    if (!read) return read.error();
    Result<fsm::Replayed> made = fsm::Replay(
        read.value(), machine, [&](std::string_view name, std::string_view text) -> Result<> {
          apply(py::str(name.data(), name.size()), py::str(text.data(), text.size()));
          return Ok();
        });
    if (!made) return made.error();
    replayed = std::move(made).value();
    return Ok();
  });
  return replayed;
}

std::string FsmMachine::Save() {
  std::string text;
  Change([&](fsm::Machine& machine) -> Result<> {
    const Result<fsm::Snapshot> saved = machine.Save();
    if (!saved) return saved.error();
    Result<std::string> written = fsm::WriteSnapshot(saved.value());
    if (!written) return written.error();
    text = std::move(written).value();
    return Ok();
  });
  return text;
}

void FsmMachine::Restore(const std::string& text, const std::string& file, Time now) {
  Change([&](fsm::Machine& machine) { return fsm::RestoreSnapshot(machine, text, file, now); });
}

int FsmMachine::Visit(visitproc visit, void* arg) const {
  if (!owned_) return 0;  // visited by that of the machine around it
  return VisitAll(visit, arg);
}

int FsmMachine::VisitAll(visitproc visit, void* arg) const {
  const auto all = [&](const auto& things) {
    for (const auto& thing : things) {
      if (const int result = thing->Visit(visit, arg); result != 0) return result;
    }
    return 0;
  };
  if (const int result = errors_->Visit(visit, arg); result != 0) return result;
  if (const int result = all(listeners_); result != 0) return result;
  if (recorder_) {
    if (const int result = recorder_->Visit(visit, arg); result != 0) return result;
  }
  if (const int result = all(states_); result != 0) return result;
  for (const auto& function : functions_) Py_VISIT(function->ptr());
  for (const auto& inside : inside_) {
    if (const int result = inside->VisitAll(visit, arg); result != 0) return result;
  }
  return 0;
}

void FsmMachine::Clear() {
  for (const auto& inside : inside_) inside->Clear();
  machine_ = nullptr;
  recorder_.reset();  // it listens to the machine
  owned_.reset();
  listeners_.clear();
  states_.clear();
  functions_.clear();
  inside_.clear();
  errors_->Report(py::none());
}

fsm::Machine& FsmMachine::Own() const {
  if (!owned_) {
    Raise("Failure", {kCodeStateInvalid,
                      machine().name() + " is inside a state, which starts, ticks and stops it"});
  }
  return *owned_;
}

// Only a machine that has neither been built nor taken by a state: the engine counts on it.
fsm::Machine& FsmMachine::Unbuilt() const {
  fsm::Machine& machine = Own();
  if (built_) {
    Raise("Failure", {kCodeStateInvalid,
                      machine.name() + " is built already: states, events and checks come before"});
  }
  return machine;
}

std::shared_ptr<StateCalls> FsmMachine::CallsOf(const py::tuple& hooks) {
  states_.push_back(std::make_shared<StateCalls>(*machine_, errors_, hooks));
  return states_.back();
}

}  // namespace musher::python
