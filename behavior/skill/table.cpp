#include "musher/behavior/skill/table.hpp"

#include <algorithm>
#include <utility>

#include "musher/base/suggest.hpp"

namespace musher::skill {
namespace {

// Names are used in paths ("RUNNING/take_off") and as TOML keys.
std::optional<std::string> NameFault(const std::string& kind, const std::string& name) {
  if (name.empty()) return "a " + kind + " has no name";
  const bool plain = std::ranges::all_of(
      name, [](char c) { return c != '/' && c != 0x7f && static_cast<unsigned char>(c) >= 0x20; });
  if (plain) return std::nullopt;
  return kind + " " + name + ": a name has no slash and no control characters";
}

void AddLine(std::string& lines, const std::string& line) {
  lines += (lines.empty() ? "" : "\n") + line;
}

}  // namespace

std::string SecondsText(Duration time) {
  return ToText(Value(ToSeconds(time))) + " s";
}

Table::Table() {
  const auto add = [this](const char* name, fsm::Role role) {
    chart_.states.push_back({name, role, {}});
    state_limits_.push_back(kNoLimit);
  };
  add("IDLE", fsm::Role::kNormal);
  for (const char* end : {"SUCCEEDED", "FAILED", "CANCELLED"}) add(end, fsm::Role::kFinal);
  chart_.start = kIdle;
}

StateId Table::State(const std::string& name, Duration limit) {
  if (const auto fault = NameFault("state", name)) errors_.push_back(*fault);
  if (Find(name)) errors_.push_back("state " + name + ": is declared twice");
  const auto id = static_cast<StateId>(chart_.states.size());
  if (first() == kIdle) chart_.transitions.push_back({kIdle, id, "request"});
  chart_.states.push_back({name, fsm::Role::kNormal, {}});
  state_limits_.push_back(limit);
  return id;
}

void Table::To(StateId from, StateId to, const std::string& when) {
  const std::size_t count = chart_.states.size();
  if (fsm::Index(from) >= count || fsm::Index(to) >= count) {
    errors_.push_back("a transition (" + when + ") is from or to a state that was not declared");
  } else {
    chart_.transitions.push_back({from, to, when});
  }
}

void Table::Uses(const std::string& part) {
  if (const auto fault = NameFault("part", part)) errors_.push_back(*fault);
  if (std::ranges::find(parts_, part) == parts_.end()) parts_.push_back(part);
}

void Table::UsesWhen(const std::string& part, When when) {
  if (const auto fault = NameFault("part", part)) errors_.push_back(*fault);
  parts_when_.emplace_back(part, std::move(when));
}

std::vector<std::string> Table::PartsFor(const Values& parameters) const {
  std::vector<std::string> parts = parts_;
  for (const auto& [part, when] : parts_when_) {
    if (std::ranges::find(parts, part) == parts.end() && when(parameters)) parts.push_back(part);
  }
  return parts;
}

void Table::Takes(const std::string& name, const Value& otherwise, const std::string& meaning) {
  AddParameter({name, KindOf(otherwise), otherwise, meaning});
}

void Table::Needs(const std::string& name, Kind kind, const std::string& meaning) {
  AddParameter({name, kind, std::nullopt, meaning});
}

void Table::AddParameter(Parameter parameter) {
  if (const auto fault = NameFault("parameter", parameter.name)) errors_.push_back(*fault);
  if (FindParameter(parameter.name) != nullptr) {
    errors_.push_back("parameter " + parameter.name + ": is declared twice");
  }
  parameters_.push_back(std::move(parameter));
}

void Table::Also(const std::string& parameter, const std::string& name) {
  const auto found = std::ranges::find(parameters_, parameter, &Parameter::name);
  if (const auto fault = NameFault("parameter", name)) errors_.push_back(*fault);
  if (found == parameters_.end() || FindParameter(name) != nullptr) {
    return errors_.push_back("parameter " + name + ": is no other name of " + parameter);
  }
  found->meaning += "; also " + name;
  other_names_.emplace_back(name, parameter);
}

void Table::RefusesParameter(const std::string& name, const std::string& why) {
  refused_.emplace_back(name, why);
}

std::string_view Table::Name(StateId state) const {
  return fsm::Index(state) < chart_.states.size()
             ? std::string_view(chart_.states[fsm::Index(state)].name)
             : "";
}

std::optional<StateId> Table::Find(std::string_view state) const {
  const auto found = std::ranges::find(chart_.states, state, &fsm::Chart::Node::name);
  if (found == chart_.states.end()) return std::nullopt;
  return static_cast<StateId>(found - chart_.states.begin());
}

StateId Table::first() const {
  constexpr std::size_t kBuiltIn = 4;
  return chart_.states.size() > kBuiltIn ? static_cast<StateId>(kBuiltIn) : kIdle;
}

Duration Table::LimitOf(StateId state) const {
  return fsm::Index(state) < state_limits_.size() ? state_limits_[fsm::Index(state)] : kNoLimit;
}

Result<> Table::SetLimit(std::string_view state, Duration limit) {
  const auto found = Find(state);
  if (!found || *found == kIdle || IsEnd(*found)) {
    std::vector<std::string_view> names;
    for (std::size_t i = fsm::Index(first()); i < chart_.states.size(); ++i) {
      names.push_back(chart_.states[i].name);
    }
    return Error{kCodeParametersInvalid, "there is no state " + std::string(state) +
                                             " with a time" + DidYouMean(state, names)};
  }
  state_limits_[fsm::Index(*found)] = limit;
  return Ok();
}

bool Table::Declared(StateId from, StateId to) const {
  return std::ranges::any_of(chart_.transitions, [&](const fsm::ChartTransition& transition) {
    return transition.from == from && transition.to == to;
  });
}

const Table::Parameter* Table::FindParameter(std::string_view name) const {
  const auto other =
      std::ranges::find_if(other_names_, [&](const auto& names) { return names.first == name; });
  const auto found = std::ranges::find(
      parameters_, other == other_names_.end() ? name : std::string_view(other->second),
      &Parameter::name);
  return found == parameters_.end() ? nullptr : &*found;
}

Result<> Table::SetDefault(std::string_view parameter, const Value& value) {
  const auto found = std::ranges::find(parameters_, parameter, &Parameter::name);
  if (found == parameters_.end()) {
    return Error{kCodeParametersInvalid, UnknownParameter(parameter)};
  }
  Result<Value> valid = As(found->kind, value);
  if (!valid) {
    return Error{valid.error().code, "parameter " + found->name + ": " + valid.error().message};
  }
  found->otherwise = std::move(valid).value();
  return Ok();
}

Result<> Table::Apply(const Settings& settings) {
  limits_.run = settings.run.value_or(limits_.run);
  limits_.cancel = settings.cancel.value_or(limits_.cancel);
  limits_.retries = settings.retries.value_or(limits_.retries);
  std::string errors;
  for (const auto& [state, limit] : settings.states) {
    if (const Result<> set = SetLimit(state, limit); !set) AddLine(errors, set.error().message);
  }
  for (const Values::Named& named : settings.parameters) {
    const Result<> set = SetDefault(named.name, named.value);
    if (!set) AddLine(errors, set.error().message);
  }
  if (errors.empty()) return Ok();
  return Error{kCodeParametersInvalid, errors};
}

std::string Table::UnknownParameter(std::string_view name) const {
  for (const auto& [refused, why] : refused_) {
    if (refused == name) return "there is no parameter " + refused + ": " + why;
  }
  std::vector<std::string_view> names;
  names.reserve(parameters_.size());
  for (const Parameter& parameter : parameters_) names.push_back(parameter.name);
  return "there is no parameter " + std::string(name) + DidYouMean(name, names);
}

Result<Values> Table::Complete(const Values& given) const {
  Values complete;
  std::string errors;
  Values known;
  for (const Values::Named& named : given) {
    const Parameter* parameter = FindParameter(named.name);
    if (parameter == nullptr) {
      AddLine(errors, UnknownParameter(named.name));
    } else if (known.Find(parameter->name) != nullptr) {
      AddLine(errors, "parameter " + parameter->name + ": is given twice");
    } else {
      known.Set(parameter->name, named.value);
    }
  }
  for (const Parameter& parameter : parameters_) {
    const Value* found = known.Find(parameter.name);
    if (found == nullptr && !parameter.otherwise) {
      AddLine(errors, "the parameter " + parameter.name + " is missing: " +
                          std::string(skill::Name(parameter.kind)) + ", " + parameter.meaning);
      continue;
    }
    const Result<Value> value =
        As(parameter.kind, found == nullptr ? *parameter.otherwise : *found);
    if (value) {
      complete.Set(parameter.name, value.value());
    } else {
      AddLine(errors, "parameter " + parameter.name + ": " + value.error().message);
    }
  }
  if (!errors.empty()) return Error{kCodeParametersInvalid, errors};
  return complete;
}

Result<Values> Table::Parse(const std::vector<std::pair<std::string, std::string>>& given) const {
  Values values;
  std::string errors;
  for (const auto& [name, text] : given) {
    const Parameter* parameter = FindParameter(name);
    if (parameter == nullptr) {
      AddLine(errors, UnknownParameter(name));
      continue;
    }
    if (values.Find(parameter->name) != nullptr) {
      AddLine(errors, "parameter " + parameter->name + ": is given twice");
    }
    Result<Value> value = skill::Parse(parameter->kind, text);
    if (value) {
      values.Set(parameter->name, std::move(value).value());
    } else {
      AddLine(errors, "parameter " + name + ": " + value.error().message);
    }
  }
  if (!errors.empty()) return Error{kCodeParametersInvalid, errors};
  return Complete(values);
}

const std::string* SharedPart(const std::vector<std::string>& one,
                              const std::vector<std::string>& other) {
  const auto found = std::ranges::find_first_of(one, other);
  return found == one.end() ? nullptr : &*found;
}

std::string ToText(const Table::Parameter& parameter) {
  std::string text = parameter.name + ": " + std::string(Name(parameter.kind)) + ", " +
                     (parameter.otherwise ? "default " + ToText(*parameter.otherwise) : "required");
  return parameter.meaning.empty() ? text : text + " (" + parameter.meaning + ")";
}

}  // namespace musher::skill
