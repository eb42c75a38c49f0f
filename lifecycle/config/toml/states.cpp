// [[state]], [[transition]] and the check of state names.

#include <algorithm>
#include <unordered_map>

#include "musher/base/toml/names.hpp"
#include "musher/lifecycle/config/toml/draft.hpp"
#include "musher/lifecycle/state.hpp"

namespace musher::config_toml {
namespace {

constexpr Rank kHighestRank = 100;

void ReadOwnState(const Value& value, Draft& draft) {
  TableReader state(*value.As<Table>(), value.at, "state", draft.findings);
  state.Require("name", "a string");
  state.Require("rank", "an integer from 0 (TearDown) to 100; Active has 6");
  const auto name = state.String("name");
  const auto rank = state.Integer("rank", 0, kHighestRank);
  state.RefuseOthers();
  if (!name) return;
  if (!IsName(name->text)) {
    state.Fault(name->at, "name",
                "expected " + std::string(kNameRule) + ", found " + Quote(name->text));
  } else if (IsBuiltInState(name->text)) {
    state.Fault(name->at, "name", Quote(name->text) + " is built in; expected a new name");
  } else if (name->text == kUnknownState) {
    state.Fault(name->at, "name",
                Quote(name->text) + " stands for a state that is not known; expected another name");
  } else if (!draft.config.ranks.emplace(name->text, static_cast<Rank>(rank.value_or(0))).second) {
    state.Fault(name->at, "name", Quote(name->text) + " is declared twice");
  }
}

// The edges of each [[transition]], as a matrix of the listed states.
class FlowReader {
 public:
  explicit FlowReader(Draft& draft)
      : draft_(draft), size_(draft.config.states.size()), edges_(size_ * size_, false) {
    for (std::size_t i = 0; i < size_; ++i) index_.emplace(draft.config.states[i], i);
  }

  void Read(const Value& value) {
    TableReader transition(*value.As<Table>(), value.at, "transition", draft_.findings);
    transition.Require("from", "a state, an array of states or \"*\"");
    transition.Require("to", "a state or an array of states");
    const auto from = Indices(transition, "from");
    const auto to = Indices(transition, "to");
    transition.RefuseOthers();
    for (const std::size_t f : from) {
      for (const std::size_t t : to) {
        if (f != t) edges_[f * size_ + t] = true;
      }
    }
    if (from.size() == 1 && from == to) {
      transition.Fault(transition.At("to"), "to", "a state needs no transition to itself");
    }
  }

  std::vector<FlowEdge> Flow() const {
    std::vector<FlowEdge> flow;
    const std::vector<State>& states = draft_.config.states;
    for (std::size_t edge = 0; edge < edges_.size(); ++edge) {
      if (edges_[edge]) flow.push_back({states[edge / size_], states[edge % size_]});
    }
    return flow;
  }

 private:
  std::vector<std::size_t> Indices(TableReader& transition, std::string_view key) {
    std::vector<std::size_t> indices;
    for (const Word& word : transition.StringOrStrings(key).value_or(std::vector<Word>{})) {
      if (key == "from" && word.text == "*") {
        AddAllThatCanBeLeft(indices);
      } else if (CheckWay(word, key, transition)) {
        const auto found = index_.find(word.text);
        if (found != index_.end()) indices.push_back(found->second);
      }
    }
    return indices;
  }

  void AddAllThatCanBeLeft(std::vector<std::size_t>& indices) const {
    for (const auto& [state, i] : index_) {
      if (state != kTearDown && draft_.config.ranks.contains(State(state))) indices.push_back(i);
    }
  }

  bool CheckWay(const Word& word, std::string_view key, TableReader& transition) {
    if (word.text == kTearDown && key == "from") {
      transition.Fault(word.at, key, "TearDown is final: only a new start follows it");
      return false;
    }
    if (word.text == kSelfCheck) return CheckState(word, key, transition, draft_);
    return CheckRankedState(word, key, transition, draft_);
  }

  Draft& draft_;
  std::size_t size_;
  std::vector<bool> edges_;  // row: from, column: to
  std::unordered_map<std::string_view, std::size_t> index_;
};

bool IsKnown(std::string_view state, const Draft& draft) {
  const auto& known = draft.known_states;
  return std::find(known.begin(), known.end(), state) != known.end();
}

}  // namespace

void ReadOwnStates(TableReader& root, Draft& draft) {
  for (const std::string_view state : BuiltInStates()) {
    if (const auto rank = BuiltInRank(state)) draft.config.ranks.emplace(state, *rank);
  }
  for (const Value* value : root.Tables("state")) ReadOwnState(*value, draft);
  draft.known_states.assign(BuiltInStates().begin(), BuiltInStates().end());
  for (const auto& [state, rank] : draft.config.ranks) {
    if (!IsBuiltInState(state)) draft.known_states.push_back(state);
  }
}

void ReadTransitions(TableReader& root, Draft& draft) {
  if (!root.Has("transition")) {
    draft.config.flow = DefaultFlow(draft.config.states);
    return;
  }
  FlowReader flow(draft);
  for (const Value* value : root.Tables("transition")) flow.Read(*value);
  draft.config.flow = flow.Flow();
}

bool MayList(const std::string& actuator, const State& state, const Draft& draft) {
  const auto states = draft.actuator_states.find(actuator);
  return states == draft.actuator_states.end() || states->second.contains(state);
}

bool CheckState(const Word& state, std::string_view key, TableReader& reader, Draft& draft) {
  if (draft.listed_states.contains(state.text)) return true;
  if (IsKnown(state.text, draft)) {
    if (!draft.states_read) return true;
    reader.Fault(state.at, key, Quote(state.text) + " is not among controller.states");
    return false;
  }
  const std::vector<std::string_view> listed(draft.config.states.begin(),
                                             draft.config.states.end());
  const auto& candidates = draft.states_read ? listed : draft.known_states;
  std::string guess = draft.findings.Guess(state.text, candidates);
  if (guess.empty()) {
    guess = draft.states_read ? "; expected one of controller.states: " + Listing(listed)
                              : "; expected a built-in state or one declared by [[state]]";
  }
  reader.Fault(state.at, key, "unknown state " + Quote(state.text) + guess);
  return false;
}

bool CheckRankedState(const Word& state, std::string_view key, TableReader& reader, Draft& draft) {
  if (!CheckState(state, key, reader, draft)) return false;
  // A typing error in controller.states, which has been reported there, is not a step of the start.
  if (draft.config.ranks.contains(State(state.text)) || !IsKnown(state.text, draft)) return true;
  reader.Fault(state.at, key,
               Quote(state.text) + " is a step of the start; expected a state that has a rank");
  return false;
}

}  // namespace musher::config_toml
