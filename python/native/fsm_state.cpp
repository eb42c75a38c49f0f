#include "musher/python/native/fsm_state.hpp"

#include <cmath>
#include <stdexcept>
#include <utility>

#include "musher/base/code.hpp"
#include "musher/python/native/numbers.hpp"

namespace musher::python {
namespace {

const char* NameOf(StateCalls::Hook hook) {
  constexpr std::array<const char*, StateCalls::kHooks> kNames{
      "declare", "on_enter", "run", "check_transition", "transition", "on_exit", "persist"};
  return kNames[hook];
}

std::string Shown(const py::object& value) {
  return py::module_::import("musher._log").attr("short")(value).cast<std::string>();
}

[[noreturn]] void ThrowReturned(const std::string& function, const py::object& returned,
                                const char* expected) {
  throw std::runtime_error(function + " returned " + Shown(returned) + "; " + expected);
}

}  // namespace

fsm::Transitions& FsmTransitions::Get() const {
  if (transitions == nullptr) {
    Raise("Failure", {kCodeStateInvalid, "transitions are declared in declare() only"});
  }
  return *transitions;
}

void FsmTransitions::To(const std::string& state, const std::string& when, fsm::Into into) const {
  calls->AddTarget(state, into, Get().To(state, when, into));
}

fsm::Archive& FsmArchive::Get() const {
  if (archive == nullptr) {
    Raise("Failure", {kCodeStateInvalid, "fields are saved and restored in persist() only"});
  }
  return *archive;
}

py::object FsmArchive::Field(const std::string& name, const py::object& value) const {
  const auto pass = [&](auto field) -> py::object {
    Get().Field(name, field);
    return py::cast(field);
  };
  if (py::isinstance<py::bool_>(value)) return pass(value.cast<bool>());
  if (py::isinstance<py::int_>(value)) {
    const auto whole = ToNumber<std::int64_t>(value);
    if (!whole) throw py::value_error(name + ": it is not " + NumberText<std::int64_t>());
    const py::object passed = pass(*whole);
    const bool is_plain = PyLong_CheckExact(value.ptr()) != 0;
    return is_plain ? passed : py::type::of(value)(passed);  // an IntEnum stays one
  }
  if (py::isinstance<py::float_>(value)) return pass(value.cast<double>());
  if (py::isinstance<py::str>(value)) return pass(value.cast<std::string>());
  throw py::type_error(name + ": a saved field is a bool, an int, a float or a str, not " +
                       Shown(value));
}

double FsmArchive::FieldOfSeconds(const std::string& name, double value_s) const {
  if (!(std::abs(value_s) <= 1e9)) {
    throw py::value_error(name + ": a saved time is at most 1e9 seconds, not " +
                          Shown(py::float_(value_s)));
  }
  // Rounded: a restored time is saved as the same number.
  const Duration before(std::llround(value_s * 1e9));
  Duration time = before;
  Get().Field(name, time);
  return time == before ? value_s : ToSeconds(time);
}

PyEventType::PyEventType(py::object data_class)
    : data_class_(std::move(data_class)), type_{[this] {
        return std::make_shared<PyEventData>(*this, data_class_());
      }} {
  const py::module_ fsm = py::module_::import("musher.fsm");
  for (const py::handle field : fsm.attr("_event_fields")(data_class_)) {
    fields_.push_back(field.cast<std::string>());
  }
  defaults_ = data_class_();
}

const PyEventType& PyEventType::Of(const py::object& data_class) {
  static auto& types = *new std::map<PyObject*, std::unique_ptr<PyEventType>>;  // ends with Python
  auto& type = types[data_class.ptr()];
  if (!type) {
    try {
      type.reset(new PyEventType(data_class));
    } catch (...) {
      types.erase(data_class.ptr());
      throw;
    }
  }
  return *type;
}

void PyEventType::Check(const py::object& value) const {
  py::module_::import("musher.fsm").attr("_check_event")(value, defaults_, fields_);
}

void PyEventData::Persist(fsm::Archive& archive) {
  const auto pass = [&](const std::string& name, auto field) {
    const auto before = field;
    archive.Field(name, field);
    if (field == before) return;
    // Also of a frozen dataclass: it is being made.
    py::module_::import("builtins").attr("object").attr("__setattr__")(value_, name, field);
  };
  for (const std::string& name : type_.fields()) {
    const py::object field = value_.attr(name.c_str());
    if (py::isinstance<py::bool_>(field)) {
      pass(name, field.cast<bool>());
    } else if (py::isinstance<py::int_>(field)) {
      pass(name, field.cast<std::int64_t>());
    } else if (py::isinstance<py::float_>(field)) {
      pass(name, field.cast<double>());
    } else {
      pass(name, field.cast<std::string>());
    }
  }
}

py::object PythonErrors::Call(const py::object& function, const py::object& argument) {
  auto result =
      py::reinterpret_steal<py::object>(CallPython(function.ptr(), py::make_tuple(argument).ptr()));
  if (result) return result;
  py::error_already_set raised;
  if (raised.trace()) PyException_SetTraceback(raised.value().ptr(), raised.trace().ptr());
  const std::string text =
      py::module_::import("musher._log").attr("where")(raised.value()).cast<std::string>();
  if (!report_.is_none()) report_(raised.value());
  if (!raised.matches(PyExc_Exception) && !kept_) kept_ = raised;
  throw std::runtime_error(text);
}

void PythonErrors::RaiseKept() {
  if (!kept_) return;
  const py::error_already_set kept = *std::exchange(kept_, std::nullopt);
  throw kept;
}

int PythonErrors::Visit(visitproc visit, void* arg) const {
  Py_VISIT(report_.ptr());
  return 0;
}

void CallPersist(PythonErrors& errors, const py::object& function, fsm::Archive& archive) {
  const py::object passed = py::cast(FsmArchive{&archive});
  const auto end = [&] { passed.cast<FsmArchive&>().archive = nullptr; };
  py::object returned;
  try {
    returned = errors.Call(function, passed);
  } catch (...) {
    end();
    throw;
  }
  end();
  if (!returned.is_none()) ThrowReturned("persist", returned, "it returns nothing");
}

StateCalls::StateCalls(const fsm::Machine& machine, std::shared_ptr<PythonErrors> errors,
                       const py::tuple& hooks)
    : machine_(machine), errors_(std::move(errors)) {
  for (std::size_t i = 0; i < kHooks; ++i) hooks_[i] = hooks[i];
}

void StateCalls::Declare(fsm::Transitions& transitions) {
  if (!Has(kDeclare)) return;
  targets_.clear();
  const py::object passed = py::cast(FsmTransitions{&transitions, this});
  const auto end = [&] { passed.cast<FsmTransitions&>().transitions = nullptr; };
  try {
    errors_->Call(hooks_[kDeclare], passed);
  } catch (...) {
    end();
    throw;
  }
  end();
}

void StateCalls::Call(Hook hook, const fsm::Tick& tick) const {
  if (!Has(hook)) return;
  const py::object returned = errors_->Call(hooks_[hook], TickOf(tick));
  if (!returned.is_none()) ThrowReturned(NameOf(hook), returned, "it returns nothing");
}

fsm::Next StateCalls::Check(const fsm::Tick& tick) const {
  if (!Has(kCheck)) return fsm::Next::Stay();
  return ToNext(errors_->Call(hooks_[kCheck], TickOf(tick)));
}

fsm::Next StateCalls::ToNext(const py::object& returned) const {
  if (returned.is_none()) return fsm::Next::Stay();
  if (!py::isinstance<FsmNext>(returned)) {
    ThrowReturned(NameOf(kCheck), returned, "it returns a musher.fsm.Next, or nothing to stay");
  }
  const auto& next = returned.cast<const FsmNext&>();
  const auto with_use = [&next](const fsm::Next& decided) {
    return next.use == FsmNext::Use::kKept ? decided.KeepCommand() : decided;
  };
  if (next.target.empty()) {
    return next.use == FsmNext::Use::kHandled ? fsm::Next::Handle() : with_use(fsm::Next::Stay());
  }
  const auto declared = targets_.find({next.target, next.into});
  if (declared != targets_.end()) return with_use(fsm::Next::To(declared->second, next.gradually));
  const auto target = machine_.FindState(next.target);
  if (!target) throw std::runtime_error("it went to " + next.target + ", which is no state");
  return with_use(fsm::Next::To(*target, next.gradually));
}

bool StateCalls::Transition(const fsm::Tick& tick) const {
  if (!Has(kTransition)) return tick.transition_elapsed >= tick.transition_time;
  const py::object returned = errors_->Call(hooks_[kTransition], TickOf(tick));
  if (!py::isinstance<py::bool_>(returned)) {
    ThrowReturned(NameOf(kTransition), returned, "it returns whether the transition is complete");
  }
  return returned.cast<bool>();
}

void StateCalls::Persist(fsm::Archive& archive) const {
  if (Has(kPersist)) CallPersist(*errors_, hooks_[kPersist], archive);
}

int StateCalls::Visit(visitproc visit, void* arg) const {
  for (const py::object& hook : hooks_) Py_VISIT(hook.ptr());
  return 0;
}

py::object StateCalls::TickOf(const fsm::Tick& tick) const {
  return MakeTick(machine_, tick);
}

py::object MakeTick(const fsm::Machine& machine, const fsm::Tick& tick) {
  FsmTick made{tick};
  if (tick.command != fsm::kNoEvent)
    made.command = py::str(std::string(machine.Name(tick.command)));
  if (const auto* data = dynamic_cast<const PyEventData*>(tick.data)) made.data = data->value();
  if (tick.target != fsm::kNoState) made.target = py::str(std::string(machine.Name(tick.target)));
  return py::cast(std::move(made));
}

void PyNested::OnExit(const fsm::Tick& tick) {
  try {
    Nested::OnExit(tick);
  } catch (...) {
    try {
      calls_->Call(StateCalls::kExit, tick);
    } catch (const std::exception&) {  // the first failure is reported
    }
    throw;
  }
  calls_->Call(StateCalls::kExit, tick);
}

}  // namespace musher::python
