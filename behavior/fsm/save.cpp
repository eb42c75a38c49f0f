// Machine::Save().

#include <algorithm>
#include <exception>
#include <utility>

#include "musher/behavior/fsm/snapshot.hpp"

namespace musher::fsm {
namespace {

template <class Persist>
void SavePart(const std::string& name, std::vector<Snapshot::Part>& parts, Persist&& persist) {
  Snapshot::Part part{name, SaveFields(persist)};
  if (!part.fields.empty()) parts.push_back(std::move(part));
}

}  // namespace

// The persisted fields of states and data, and the machines inside.
Result<> Machine::SaveParts(Snapshot& saved) const {
  const std::string* at = nullptr;
  try {
    for (const Data& data : data_) SavePart(*(at = &data.name), saved.data, data.persist);
    for (const Node& node : nodes_) {
      SavePart(*(at = &node.name), saved.states,
               [&](Archive& archive) { node.state->Persist(archive); });
    }
  } catch (const std::exception& thrown) {
    return Error{kCodeFailed, name() + ": " + *at + ": Persist: " + thrown.what()};
  }
  for (const Node& node : nodes_) {
    const Machine* inside = node.state->inside();
    if (inside == nullptr) continue;
    Result<Snapshot> inner = inside->Save();
    if (!inner) {
      return Error{kCodeFailed, name() + ": " + node.name + ": " + inner.error().message};
    }
    saved.inside.push_back({node.name, std::move(inner).value()});
  }
  return Ok();
}

Result<Snapshot> Machine::Save() const {
  if (in_tick_ || !built_) {
    return Error{kCodeFailed, name() + ": can be saved once it is built, and between ticks"};
  }
  const auto text = [this](auto id) { return std::string(Name(id)); };
  Snapshot saved;
  saved.machine = name();
  saved.running = running_;
  saved.paused = running_ && !last_tick_;
  saved.mode = mode_;
  saved.state = text(current_);
  saved.ticks = ticks_;
  saved.time = tick_.now;
  saved.step = tick_.step;
  saved.elapsed = elapsed();
  saved.unsafe = unsafe();
  if (mode_ == Mode::kTransitioning) {
    saved.transition = {text(tick_.target), text(cause_), tick_.transition_elapsed,
                        tick_.transition_time};
  }
  for (std::size_t i = 0; i < waiting_; ++i) {
    saved.commands.push_back(text(commands_[(first_command_ + i) % commands_.size()]));
  }
  saved.counts = counts_;
  if (fault_) {
    saved.fault = {text(fault_->state), fault_->phase, fault_->at, fault_->what, fault_->where};
  }
  for (std::size_t i = 0; i < history_.size(); ++i) {
    const Change& change = history_[i];
    saved.history.push_back({change.at, change.tick, text(change.from), text(change.to),
                             text(change.command), change.cause});
  }
  if (const Result<> parts = SaveParts(saved); !parts) return parts.error();
  return saved;
}

}  // namespace musher::fsm
