#pragma once
// A state of a machine (behavior/fsm) that calls the functions of a Python object (musher/fsm.py),
// and what they get and return.
//
// Threads: with the GIL.

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "musher/behavior/fsm/nested.hpp"
#include "musher/python/native/parts.hpp"

namespace musher::python {

// fsm::Tick with names for ids.
struct FsmTick {
  fsm::Tick tick;
  py::object command = py::none();  // a str, or None
  py::object target = py::none();
  py::object data = py::none();  // an object of the class that AddEvent() got, or None
};

// fsm::Next with a name for its target.
struct FsmNext {
  enum class Use { kUnhandled, kHandled, kKept };

  std::string target;  // empty: stays
  Duration gradually{};
  Use use = Use::kUnhandled;
  fsm::Into into = fsm::Into::kStart;
};

// The class of the data of an event: a dataclass whose fields are bool, int, float or str, each
// with a default.
class PyEventType {
 public:
  // The one of this class, which lives as long as the process. Raises TypeError for another class.
  static const PyEventType& Of(const py::object& data_class);

  const fsm::EventType* type() const { return &type_; }
  // Raises TypeError unless it is an object of the class, with fields of their types.
  void Check(const py::object& value) const;
  const std::vector<std::string>& fields() const { return fields_; }
  const py::object& data_class() const { return data_class_; }

 private:
  explicit PyEventType(py::object data_class);

  const py::object data_class_;
  std::vector<std::string> fields_;
  py::object defaults_;  // an object of the class
  fsm::EventType type_;
};

class PyEventData final : public fsm::EventData {
 public:
  PyEventData(const PyEventType& type, py::object value) : type_(type), value_(std::move(value)) {}

  const fsm::EventType* type() const override { return type_.type(); }
  void Persist(fsm::Archive& archive) override;
  const PyEventType& py_type() const { return type_; }
  const py::object& value() const { return value_; }

 private:
  const PyEventType& type_;
  py::object value_;
};

// fsm::Change with names for ids.
struct FsmChange {
  double at_s = 0;
  std::uint64_t tick = 0;
  std::string from;
  std::string to;
  std::string cause;
  std::string command;
};

// fsm::Archive, as long as a `persist` of Python runs.
struct FsmArchive {
  fsm::Archive* archive = nullptr;

  // A saving archive reads the value and returns it; a restoring one returns the saved value, or
  // the same one where it has none. A bool, an int, a float or a str; another one is a TypeError.
  py::object Field(const std::string& name, const py::object& value) const;
  // A time in seconds, saved as that of a Duration.
  double FieldOfSeconds(const std::string& name, double value_s) const;

 private:
  fsm::Archive& Get() const;
};

class StateCalls;

// fsm::Transitions, as long as the state declares itself.
struct FsmTransitions {
  fsm::Transitions* transitions = nullptr;
  StateCalls* calls = nullptr;

  fsm::Transitions& Get() const;
  void To(const std::string& state, const std::string& when, fsm::Into into) const;
};

// What a machine's Python objects raise. Its text is that of musher._log.where().
class PythonErrors {
 public:
  // `function` of Python with one argument; throws std::runtime_error with the text of what it
  // raised.
  py::object Call(const py::object& function, const py::object& argument);
  // An exception that is none of a fault but ends the program, such as KeyboardInterrupt, is raised
  // once the machine has handled it.
  void RaiseKept();
  // Gets each exception; None: no function.
  void Report(py::object function) { report_ = std::move(function); }
  int Visit(visitproc visit, void* arg) const;

 private:
  py::object report_ = py::none();
  std::optional<py::error_already_set> kept_;
};

// Calls `function` of Python, which saves and restores fields. Throws std::runtime_error with the
// text of what it raised.
void CallPersist(PythonErrors& errors, const py::object& function, fsm::Archive& archive);

// The functions of the Python object of a state. Those that its class does not have are None.
class StateCalls {
 public:
  enum Hook { kDeclare, kEnter, kRun, kCheck, kTransition, kExit, kPersist };
  static constexpr std::size_t kHooks = 7;

  // `machine` owns the state.
  StateCalls(const fsm::Machine& machine, std::shared_ptr<PythonErrors> errors,
             const py::tuple& hooks);

  bool Has(Hook hook) const { return !hooks_[hook].is_none(); }
  void Declare(fsm::Transitions& transitions);
  void AddTarget(const std::string& state, fsm::Into into, fsm::StateId id) {
    targets_[{state, into}] = id;
  }
  void Call(Hook hook, const fsm::Tick& tick) const;
  fsm::Next Check(const fsm::Tick& tick) const;
  bool Transition(const fsm::Tick& tick) const;
  void Persist(fsm::Archive& archive) const;
  int Visit(visitproc visit, void* arg) const;

 private:
  py::object TickOf(const fsm::Tick& tick) const;
  fsm::Next ToNext(const py::object& returned) const;

  const fsm::Machine& machine_;
  const std::shared_ptr<PythonErrors> errors_;
  std::array<py::object, kHooks> hooks_;
  std::map<std::pair<std::string, fsm::Into>, fsm::StateId> targets_;  // as they were declared
};

py::object MakeTick(const fsm::Machine& machine, const fsm::Tick& tick);
py::object MakeChange(const fsm::Machine& machine, const fsm::Change& change);

class PyState final : public fsm::State {
 public:
  explicit PyState(std::shared_ptr<StateCalls> calls) : calls_(std::move(calls)) {}

  void Declare(fsm::Transitions& transitions) override { calls_->Declare(transitions); }
  void OnEnter(const fsm::Tick& tick) override { calls_->Call(StateCalls::kEnter, tick); }
  void Run(const fsm::Tick& tick) override { calls_->Call(StateCalls::kRun, tick); }
  fsm::Next CheckTransition(const fsm::Tick& tick) override { return calls_->Check(tick); }
  bool Transition(const fsm::Tick& tick) override { return calls_->Transition(tick); }
  void OnExit(const fsm::Tick& tick) override { calls_->Call(StateCalls::kExit, tick); }
  void Persist(fsm::Archive& archive) override { calls_->Persist(archive); }

 private:
  const std::shared_ptr<StateCalls> calls_;
};

// Python's on_enter and run come before the machine inside, its on_exit after it.
class PyNested final : public fsm::Nested {
 public:
  PyNested(std::shared_ptr<StateCalls> calls, std::vector<Region> regions, Options options)
      : Nested(std::move(regions), std::move(options)), calls_(std::move(calls)) {}

  void Declare(fsm::Transitions& transitions) override {
    Nested::Declare(transitions);
    calls_->Declare(transitions);
  }
  void OnEnter(const fsm::Tick& tick) override {
    calls_->Call(StateCalls::kEnter, tick);
    Nested::OnEnter(tick);
  }
  void Run(const fsm::Tick& tick) override {
    calls_->Call(StateCalls::kRun, tick);
    Nested::Run(tick);
  }
  bool Transition(const fsm::Tick& tick) override { return calls_->Transition(tick); }
  void OnExit(const fsm::Tick& tick) override;
  void Persist(fsm::Archive& archive) override {
    Nested::Persist(archive);
    calls_->Persist(archive);
  }

 protected:
  fsm::Next Decide(const fsm::Tick& tick) override { return calls_->Check(tick); }

 private:
  const std::shared_ptr<StateCalls> calls_;
};

}  // namespace musher::python
