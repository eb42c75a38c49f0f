// Saves and restores runs. See snapshot.hpp.

#include "musher/behavior/skill/snapshot.hpp"

#include <algorithm>
#include <exception>
#include <utility>

#include "musher/base/suggest.hpp"
#include "musher/behavior/skill/manager.hpp"

namespace musher::skill {

Result<Snapshot> Run::Save() const {
  if (in_step_) return Error{kCodeFailed, name_ + ": can be saved between its steps"};
  const auto text = [this](StateId state) { return std::string(table_.Name(state)); };
  Snapshot saved;
  saved.skill = name_;
  saved.state = text(state_);
  saved.entered = entered_;
  saved.paused = paused_;
  saved.pause_requested = pause_requested_;
  saved.pause_why = pause_why_;
  saved.ticks = ticks_;
  saved.time = now_;
  saved.elapsed = elapsed_;
  saved.retries = retries_;
  saved.replans = replans_;
  saved.cancel_requested = cancel_requested_;
  saved.cancel_passed = cancel_passed_;
  saved.cancel_why = cancel_why_;
  saved.cancel_at = cancel_at_;
  saved.progress = feedback_.progress;
  saved.message = feedback_.message;
  saved.parameters = parameters_;
  saved.data = data_;
  for (std::size_t i = 0; i < history_.size(); ++i) {
    const Change& change = history_[i];
    saved.history.push_back(
        {change.at, change.tick, text(change.from), text(change.to), change.cause, change.why});
  }
  for (std::size_t i = 0; i < errors_.size(); ++i) saved.errors.push_back(errors_[i]);
  try {
    saved.fields = fsm::SaveFields([this](fsm::Archive& archive) { skill_->Persist(archive); });
  } catch (const std::exception& thrown) {
    return Error{kCodeFailed, name_ + ": Persist: " + thrown.what()};
  }
  for (const Run* run : inside_) {
    Result<Snapshot> inside = run->Save();
    if (!inside) return Error{kCodeFailed, name_ + ": " + inside.error().message};
    saved.inside.push_back(std::move(inside).value());
  }
  return saved;
}

// Restores a run that has not begun, and adds what is invalid to the faults.
class Restorer {
 public:
  Restorer(Run& run, const Snapshot& saved, std::string prefix, std::vector<SnapshotFault>& faults)
      : run_(run), saved_(saved), prefix_(std::move(prefix)), faults_(faults) {}

  void Restore() {
    if (saved_.skill != run_.name()) {
      return Fail("skill", "it was saved from " + saved_.skill + ", not from " + run_.name());
    }
    RestoreState();
    RestoreTimes();
    RestoreCancellation();
    RestoreFeedback();
    RestoreValues();
    RestoreHistory();
    const auto persist = [this](fsm::Archive& archive) { run_.skill_->Persist(archive); };
    fsm::RestoreFields(saved_.fields, fsm::SnapshotKey(prefix_, "fields"), persist, faults_);
    RestoreInside();
    run_.ShowState();
  }

 private:
  StateId State(const std::string& key, const std::string& name) {
    const auto found = run_.table_.Find(name);
    if (found) return *found;
    std::vector<std::string> known;
    for (const auto& state : run_.table_.chart().states) known.push_back(state.name);
    Fail(key, fsm::UnknownName("state", name, known));
    return kIdle;
  }

  void RestoreState() {
    run_.state_ = State("state", saved_.state);
    run_.entered_ = saved_.entered;
    run_.paused_ = saved_.paused;
    run_.pause_requested_ = saved_.pause_requested;
    run_.pause_why_ = saved_.pause_why;
    if (saved_.pause_requested && !saved_.paused) Fail("pause_requested", "is true without paused");
    run_.ticks_ = saved_.ticks;
    if (saved_.retries < 0) Fail("retries", "is negative");
    if (saved_.replans < 0) Fail("replans", "is negative");
    run_.retries_ = saved_.retries;
    run_.replans_ = saved_.replans;
  }

  void RestoreTimes() {
    Within("time", saved_.time, Duration(kFarthestNs));
    Within("elapsed", saved_.elapsed, saved_.time);
    Within("cancel_at", saved_.cancel_at, saved_.time);
    run_.now_ = saved_.time;
    run_.elapsed_ = saved_.elapsed;
    run_.cancel_at_ = saved_.cancel_at;
  }

  void RestoreCancellation() {
    if (saved_.cancel_passed && !saved_.cancel_requested) {
      Fail("cancel_passed", "is true without a request");
    }
    if (saved_.cancel_requested && run_.state_ == kSucceeded) {
      Fail("cancel_requested", "is true, but a cancelled run does not succeed");
    }
    run_.cancel_requested_ = saved_.cancel_requested;
    run_.cancel_passed_ = saved_.cancel_passed;
    run_.cancel_why_ = saved_.cancel_why;
  }

  void RestoreFeedback() {
    const bool completed = run_.state_ == kSucceeded;
    if (saved_.progress < 0 || saved_.progress > 100 || (saved_.progress == 100) != completed) {
      Fail("progress", completed ? "has to be 100 in SUCCEEDED" : "has to be between 0 and 99");
    }
    run_.feedback_.progress = saved_.progress;
    run_.feedback_.message = saved_.message;
    run_.feedback_.status = completed                   ? Status::kCompleted
                            : run_.state_ == kFailed    ? Status::kFailed
                            : run_.state_ == kCancelled ? Status::kCancelled
                                                        : Status::kProcessing;
    run_.feedback_.paused = saved_.paused && run_.running();
  }

  void RestoreValues() {
    run_.data_ = saved_.data;
    run_.parameters_ = saved_.parameters;
    if (run_.state_ == kIdle) return;
    Result<Values> complete = run_.table_.Complete(saved_.parameters);
    if (complete) {
      run_.parameters_ = std::move(complete).value();
    } else {
      Fail("parameters", complete.error().message);
    }
  }

  void RestoreHistory() {
    for (std::size_t i = 0; i < saved_.history.size(); ++i) {
      const Snapshot::PastChange& change = saved_.history[i];
      const std::string key = "history[" + std::to_string(i) + "]";
      run_.history_.Add({change.at, change.tick, State(key, change.from), State(key, change.to),
                         change.cause, change.why});
    }
    for (const Failure& failure : saved_.errors) run_.errors_.Add(failure);
  }

  void RestoreInside() {
    if (saved_.inside.size() != run_.inside_.size()) {
      return Fail("inside", "has to have " + std::to_string(run_.inside_.size()) + " skills, not " +
                                std::to_string(saved_.inside.size()));
    }
    for (std::size_t i = 0; i < saved_.inside.size(); ++i) {
      const std::string key = "inside[" + std::to_string(i) + "]";
      Restorer inside(*run_.inside_[i], saved_.inside[i], fsm::SnapshotKey(prefix_, key), faults_);
      inside.Restore();
      if (!run_.running() && run_.inside_[i]->running()) {
        Fail(key, "runs, but " + run_.name() + " does not");
      }
    }
  }

  // From 0 to `most`.
  void Within(const std::string& key, Duration time, Duration most) {
    if (time >= Duration{} && time <= most) return;
    Fail(key, "has to be between 0 and " + std::to_string(most.count()) + " ns");
  }

  void Fail(const std::string& key, std::string what) {
    faults_.push_back({fsm::SnapshotKey(prefix_, key), std::move(what)});
  }

  Run& run_;
  const Snapshot& saved_;
  const std::string prefix_;
  std::vector<SnapshotFault>& faults_;
};

Result<ManagerSnapshot> Manager::Save() const {
  ManagerSnapshot saved;
  for (const auto& run : runs_) {
    Result<Snapshot> snapshot = run->Save();
    if (!snapshot) return snapshot.error();
    saved.runs.push_back(std::move(snapshot).value());
  }
  return saved;
}

std::vector<SnapshotFault> Manager::Restore(const ManagerSnapshot& saved) {
  if (in_step_ || running()) return {{"", "skills are restored while none of them runs"}};
  std::vector<SnapshotFault> faults;
  std::vector<std::unique_ptr<Run>> before = std::exchange(runs_, {});
  for (std::size_t i = 0; i < saved.runs.size(); ++i) {
    const std::string key = "run[" + std::to_string(i) + "]";
    Result<std::unique_ptr<Run>> run = Make(saved.runs[i].skill);
    if (!run) {
      faults.push_back({key + ".skill", run.error().message});
      continue;
    }
    Run& made = *run.value();
    Restorer(made, saved.runs[i], key, faults).Restore();
    const Result<> free =
        Free(made, made.pause_requested() ? std::vector<std::string>() : made.parts());
    if (made.running() && !free) faults.push_back({key + ".skill", free.error().message});
    if (Find(made.name()) != nullptr) {
      faults.push_back({key + ".skill", made.name() + " is in it twice"});
    }
    Keep(std::move(run).value());
  }
  if (!faults.empty()) {
    runs_ = std::move(before);
  } else {
    last_.reset();
  }
  return faults;
}

}  // namespace musher::skill
