// Reads a state of a course: its steps and its transitions.

#include <array>

#include "musher/base/toml/findings.hpp"
#include "musher/modules/race/course_parts.hpp"

namespace musher::race::parts {
namespace {

using config_toml::Array;
using config_toml::Value;

class StateReader {
 public:
  StateReader(TableReader& table, StateRule& state, StatePlace& place, Reading& reading)
      : table_(table), state_(state), place_(place), reading_(reading) {}

  void Read() {
    place_.at = table_.at();
    place_.next = table_.At("next");
    table_.Require("number", "the state's number in state_info");
    const auto number = table_.Integer("number", 0, 999);
    place_.has_number = number.has_value();
    state_.number = static_cast<int>(number.value_or(0));
    state_.light = table_.Bool("light").value_or(false);
    place_.on_fault = table_.At("on_fault");
    const auto on_fault = Reference(table_, "on_fault", "state", course().states);
    if (!on_fault && table_.Has("on_fault")) reading_.has_leads = false;
    state_.on_fault = on_fault.value_or(course().error);
    EachTable("steps", "a step, as in { move = \"forward\", count = 12 }",
              [this](TableReader& step) { ReadStep(step); });
    place_.has_all_steps = state_.steps.size() == ItemsOf(table_, "steps");
    place_.has_all_transitions = true;
    ReadTransitions();
    if (state_.transitions.size() != ItemsOf(table_, "next")) place_.has_all_transitions = false;
    // A step that is not known may be a wait that leads to a state.
    const bool leads = place_.has_all_steps && place_.has_all_transitions;
    if (!leads && MayLead()) reading_.has_leads = false;
  }

 private:
  const Course& course() const { return reading_.course; }

  // How many the list of the key has; another value counts as one.
  static std::size_t ItemsOf(TableReader& table, const char* key) {
    const Value* value = table.Get(key);
    if (value == nullptr) return 0;
    const auto* items = value->As<Array>();
    return items == nullptr ? 1 : items->size();
  }
  bool MayLead() const { return !place_.has_all_transitions || leads_; }

  // `read` gets each table of the list.
  template <class Read>
  void EachTable(const char* key, const char* expected, Read&& read) {
    const Value* value = table_.Get(key);
    if (value == nullptr) return;
    const auto* items = value->As<Array>();
    if (items == nullptr) {
      return table_.Fault(value->at, key,
                          "expected a list, each " + std::string(expected) + ", found " +
                              std::string(config_toml::TypeName(*value)));
    }
    for (const Value& item : *items) {
      const auto* table = item.As<Table>();
      if (table == nullptr) {
        table_.Fault(item.at, key,
                     "expected " + std::string(expected) + ", found " +
                         std::string(config_toml::TypeName(item)));
        continue;
      }
      TableReader reader(*table, item.at, table_.path() + "." + key, reading_.findings);
      read(reader);
      reader.RefuseOthers();
    }
  }

  void ReadStep(TableReader& step) {
    static constexpr std::array<const char*, 8> kKinds = {"move", "check", "wait", "until",
                                                          "walk", "say",   "set",  "add"};
    const char* kind = nullptr;
    for (const char* key : kKinds) {
      if (!step.Has(key)) continue;
      if (kind != nullptr) {
        return step.Fault(step.At(key), key,
                          "expected one step, found \"" + std::string(kind) + "\" beside it");
      }
      kind = key;
    }
    const std::string_view what = kind == nullptr ? "" : kind;
    if (what == "move") return ReadMove(step);
    if (what == "check") return ReadCheck(step);
    if (what == "wait") return Add<WaitStep>(step, "wait", course().waits);
    if (what == "walk") return Add<WalkStep>(step, "walk", course().walks);
    if (what == "say") return ReadSay(step);
    if (what == "until") return ReadUntil(step);
    if (what == "set" || what == "add") return ReadCount(step, what == "add");
    leads_ = true;
    step.Require("move", "a step, as in { move = \"forward\", count = 12 } or { check = … }");
  }

  template <class Kind, class Thing>
  void Add(TableReader& step, const char* key, const std::vector<Thing>& things) {
    if (const auto found = Reference(step, key, key, things)) {
      state_.steps.emplace_back(Kind{*found});
    } else {
      leads_ = true;
    }
  }

  std::optional<Index> CounterAt(TableReader& table, const char* key) {
    const auto word = table.String(key);
    return word ? Refer(table, key, "counter", *word, course().counters) : std::nullopt;
  }

  void ReadMove(TableReader& step) {
    const auto movement = Reference(step, "move", "movement", course().movements);
    const auto count = Count(step, "count");
    const auto less = CounterAt(step, "less");
    const auto beyond = step.Integer("beyond", 0, kMostSteps, " steps");
    const auto keep = Reference(step, "keep", "keep", course().keeps);
    const auto only = OnlyAt(step);
    if (!movement) return;
    const Movement& moved = course().movements[*movement];
    for (const char* key : {"count", "less", "beyond", "keep"}) {
      if (moved.walks || !step.Has(key)) continue;
      step.Fault(step.At(key), key, moved.name + " is one motion, and no walk");
    }
    if (moved.walks && step.Has("beyond") && !step.Has("less")) {
      step.Fault(step.At("beyond"), "beyond", "expected less = … beside it");
    }
    state_.steps.emplace_back(MoveStep{*movement, count.value_or(moved.count), less,
                                       static_cast<int>(beyond.value_or(0)), keep, only});
    if (moved.walks) turned_ = moved.twist.turns();
  }

  void ReadCheck(TableReader& step) {
    const auto check = Reference(step, "check", "check", course().checks);
    if (check) state_.steps.emplace_back(CheckStep{*check, turned_});
  }

  void ReadSay(TableReader& step) {
    const auto speech = Reference(step, "say", "speech", course().speeches);
    const auto unsure = Reference(step, "unsure", "speech", course().speeches);
    const auto only = OnlyAt(step);
    if (speech) state_.steps.emplace_back(SayStep{*speech, unsure, only});
  }

  // The walk until a sight without which the step is left out.
  std::optional<Index> OnlyAt(TableReader& step) {
    return Reference(step, "only", "until", course().untils);
  }

  void ReadUntil(TableReader& step) {
    const auto until = Reference(step, "until", "until", course().untils);
    const auto most = Count(step, "most");
    const auto stores = CounterAt(step, "stores");
    const auto keep = Reference(step, "keep", "keep", course().keeps);
    if (!until) leads_ = true;
    if (!until) return;
    state_.steps.emplace_back(UntilStep{*until, most, stores, keep});
    turned_ = false;
  }

  void ReadCount(TableReader& step, bool adds) {
    const auto counter = CounterAt(step, adds ? "add" : "set");
    const char* key = adds ? "by" : "to";
    step.Require(key, "a number");
    const auto number = step.Integer(key, adds ? 1 : 0, kMostSteps);
    const auto only = OnlyAt(step);
    if (counter && number) {
      state_.steps.emplace_back(CountStep{*counter, static_cast<int>(*number), adds, only});
    }
  }

  void ReadTransitions() {
    const Value* next = table_.Get("next");
    if (next == nullptr) return;
    if (next->As<std::string>() != nullptr) return AddTransition(table_, "next", {});
    EachTable("next", "a transition, as in { to = \"END\" }, or the name of a state",
              [this](TableReader& transition) { ReadTransition(transition); });
  }

  void ReadTransition(TableReader& table) {
    TransitionRule transition;
    std::size_t errors = 0;
    transition.result = Reference(table, "result", "result", course().results);
    if (table.Has("result")) table.Require("is", "a value of the result");
    if (const auto word = table.String("is"); word && transition.result) {
      const auto is =
          Refer(table, "is", "value", *word, course().results[*transition.result].values);
      if (!is) ++errors;
      transition.is = is.value_or(0);
    } else if (word && !table.Has("result")) {
      table.Fault(word->at, "is", "expected result = … beside it");
    }
    transition.from = States(table, "from", reading_);
    if (transition.from.size() != ItemsOf(table, "from")) ++errors;
    transition.counter = CounterAt(table, "counter");
    const auto number = [&](const char* key, std::optional<int>& limit) {
      if (const auto read = table.Integer(key, 0, kMostSteps)) limit = static_cast<int>(*read);
      if (table.Has(key) != limit.has_value()) ++errors;
      if (table.Has(key) && !table.Has("counter")) {
        table.Fault(table.At(key), key, "expected counter = … beside it");
      }
    };
    number("below", transition.below);
    number("at_least", transition.at_least);
    if (transition.counter && !transition.below && !transition.at_least) {
      table.Fault(table.At("counter"), "counter", "expected below = … or at_least = … beside it");
    }
    const bool whole = table.Has("result") == transition.result.has_value() &&
                       table.Has("result") == table.Has("is") &&
                       table.Has("counter") == transition.counter.has_value();
    if (!whole || errors > 0) place_.has_all_transitions = false;
    table.Require("to", "the name of a state");
    AddTransition(table, "to", transition);
  }

  void AddTransition(TableReader& table, const char* key, TransitionRule transition) {
    const auto word = table.String(key);
    if (!word) return;
    if (word->text == kBack) {
      transition.to = kInterrupted;
    } else {
      const auto to = Refer(table, key, "state", *word, NamesOf(course().states));
      if (!to) return;
      transition.to = *to;
    }
    state_.transitions.push_back(std::move(transition));
    place_.transitions.push_back(word->at);
  }

  TableReader& table_;
  StateRule& state_;
  StatePlace& place_;
  Reading& reading_;
  bool turned_ = false;  // by the last movement so far
  bool leads_ = false;   // a step that is not known may lead to a state
};

}  // namespace

void ReadState(TableReader& table, StateRule& state, StatePlace& place, Reading& reading) {
  StateReader(table, state, place, reading).Read();
}

}  // namespace musher::race::parts
