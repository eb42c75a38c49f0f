#pragma once
// A state machine (behavior/fsm) with states of Python.
//
//   Python's Machine ──▶ FsmMachine ──owns──▶ fsm::Machine ──owns──▶ PyState ──▶ Python's State
//
// A state that holds a machine takes it over: its FsmMachine then only reads it.
//
// Threads: with the GIL. A state's function may let another Python thread run; the machine refuses
// what that thread must not do then.

#include <memory>
#include <string>
#include <vector>

#include "musher/behavior/fsm/replay.hpp"
#include "musher/python/native/fsm_state.hpp"

namespace musher::python {

class FsmMachine {
 public:
  explicit FsmMachine(fsm::Machine::Options options);
  ~FsmMachine();
  FsmMachine(const FsmMachine&) = delete;
  FsmMachine& operator=(const FsmMachine&) = delete;

  // --- before build ---
  void Add(const std::string& name, int role, const py::tuple& hooks);
  struct Inside {
    std::shared_ptr<FsmMachine> machine;
    std::string start;
  };
  void AddNested(const std::string& name, int role, const py::tuple& hooks,
                 const std::vector<Inside>& inside, fsm::Nested::Options options);
  // `data_class`: None, or see PyEventType.
  void AddEvent(const std::string& name, bool urgent, const py::object& data_class);
  void AddSafetyCheck(const std::string& name, const py::object& is_safe);
  // `persist`: a function of Python with an FsmArchive.
  void AddData(const std::string& name, const py::object& persist);
  void Build(const std::string& start);
  bool built() const { return built_; }

  // Runs `work(fsm::Machine&)`, which returns a Result or nothing and changes the machine; raises
  // musher.Failure unless it is good.
  template <class Work>
  void Change(const Work& work) {
    fsm::Machine& machine = Own();
    if (!built_) Raise("Failure", {kCodeStateInvalid, machine.name() + ": build() comes first"});
    if constexpr (std::is_void_v<decltype(work(machine))>) {
      work(machine);
      errors_->RaiseKept();
    } else {
      const Result<> result = work(machine);
      errors_->RaiseKept();
      Check(result);
    }
  }
  // `data`: None, or of the event's class.
  void Send(const std::string& command, const py::object& data);
  // Raises musher.Failure if it ended with the machine around it.
  const fsm::Machine& machine() const;

  void Listen(const py::object& changed, const py::object& unhandled, const py::object& failed,
              const py::object& kept);
  // Records it from its start on: `write` gets each line.
  void Record(const py::object& write);
  void RecordInput(const std::string& name, const std::string& text);
  // Repeats a recording; `apply` gets the name and the text of each input.
  fsm::Replayed Replay(const std::string& recording, const std::string& file,
                       const py::object& apply);
  // The machine as a text of toml/snapshot_toml.hpp, and back; `now` as in Machine::Restore().
  std::string Save();
  void Restore(const std::string& text, const std::string& file, Time now);
  // Gets each exception of a state, a check or a listener.
  void ReportExceptions(const py::object& function) { errors_->Report(function); }

  // For Python's garbage collection: a state often refers to what has the machine.
  int Visit(visitproc visit, void* arg) const;
  void Clear();

 private:
  class PyListener;
  class PyRecorder;

  int VisitAll(visitproc visit, void* arg) const;
  fsm::Machine& Own() const;
  fsm::Machine& Unbuilt() const;
  std::shared_ptr<StateCalls> CallsOf(const py::tuple& hooks);

  std::shared_ptr<PythonErrors> errors_ = std::make_shared<PythonErrors>();
  std::vector<std::unique_ptr<PyListener>> listeners_;
  std::vector<std::shared_ptr<StateCalls>> states_;
  std::vector<std::shared_ptr<py::object>> functions_;  // safety checks, and those of AddData()
  std::vector<std::shared_ptr<FsmMachine>> inside_;
  std::unique_ptr<PyRecorder> recorder_;  // after Record()
  std::unique_ptr<fsm::Machine> owned_;   // none: a state of another machine has it
  fsm::Machine* machine_ = nullptr;       // none: that machine has ended
  bool built_ = false;
};

void AddFsm(py::module_& native);
void AddFsmTicks(py::module_& native);

}  // namespace musher::python
