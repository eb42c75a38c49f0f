#pragma once
// Runs the skills of one robot: several at once, but each at most once, also as a part of another
// one, and none together with a skill that uses the same part of the robot (Table::Uses()).
//
//   skill::Manager manager(registry.All());
//   const Result<> started = manager.Start("take_off", {{"altitude", 2.0}});
//   ... each 100 ms: manager.RunOnce(now);
//   const skill::Run* run = manager.Find("take_off");  // run->feedback(), run->history(), …
//
// An ended run keeps its feedback, errors and history until the skill is started again or reset.
//
// Threads: one at a time. A skill must not start, pause, cancel or reset skills: within RunOnce()
// and Pause() those calls fail.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"
#include "musher/behavior/fsm/saved_part.hpp"
#include "musher/behavior/skill/registry.hpp"
#include "musher/behavior/skill/run.hpp"

namespace musher::skill {

struct ManagerSnapshot;  // snapshot.hpp

class Manager {
 public:
  // The first of several entries with the same name counts.
  explicit Manager(std::vector<Entry> entries);
  ~Manager();  // ends nothing
  Manager(const Manager&) = delete;
  Manager& operator=(const Manager&) = delete;

  // A new run. Fails, and changes nothing, for an unknown name, with the nearest; for a skill that
  // runs, on its own or as a part of another one, with its name; for one that needs a part of the
  // robot which a running skill uses, with both names; and for invalid parameters.
  Result<> Start(std::string_view skill, const Values& parameters = {}, Origin origin = {});
  // The same with parameters as texts, by their declared kinds.
  Result<> StartWithTexts(std::string_view skill,
                          const std::vector<std::pair<std::string, std::string>>& parameters,
                          Origin origin = {});

  // A step of each running skill, in the order of their starts. A time before the last one counts
  // as no elapsed time.
  void RunOnce(Time now);
  // The time until the next step does not count.
  void Pause();

  // Pauses one skill until Resume(), also over Pause() of all: its outputs are neutral, its time
  // stands still, and other skills may use its parts of the robot. `why` is for people: "by a
  // request". Fails, and changes nothing: see Run::PauseUntilResumed().
  Result<> Pause(std::string_view skill, const std::string& why);
  // The skill goes on with the next step. Fails, and it stays paused, when it is not paused so,
  // when a running skill uses a part of the robot that it needs, and when its preconditions do not
  // hold any more.
  Result<> Resume(std::string_view skill);

  // See Run. Fails for a skill that does not run.
  Result<> Cancel(std::string_view skill, const std::string& why);
  Result<> CancelNow(std::string_view skill, const std::string& why);
  Result<> FailNow(std::string_view skill, const std::string& why);
  void CancelAll(const std::string& why);
  void CancelAllNow(const std::string& why);
  // Removes the run, its data, errors and history; a running one is cancelled at once before.
  Result<> Reset(std::string_view skill);
  void ResetAll();

  // Called with each ended run right before it is removed, by a new start of its skill or a reset:
  // its end could not be read later. Must not use the manager.
  void OnRemoval(std::function<void(const Run&)> removal) { removal_ = std::move(removal); }

  // Called after each change of the state of a run, from the one to its first state on; of a skill
  // that runs skills, of its own states only. Must not throw, and must not use the manager.
  void OnStateChanged(std::function<void(const Run&, const Change&)> changed) {
    changed_ = std::move(changed);
  }

  // Null: it was not started since its last reset, or is unknown.
  const Run* Find(std::string_view skill) const;
  // In the order of their starts, ended ones included.
  std::vector<const Run*> Runs() const;
  bool running() const;
  // "IDLE" when it was not started since its last reset; nullopt: unknown.
  std::optional<std::string> StateOf(std::string_view skill) const;
  std::vector<std::string> Names() const;
  const std::vector<Entry>& entries() const { return entries_; }
  // A run that has not begun, for its table and its chart. Fails for an unknown name, with the
  // nearest.
  Result<std::unique_ptr<Run>> Make(std::string_view skill) const;

  // Between two steps. Fails, with the name of the skill, when one cannot be saved.
  Result<ManagerSnapshot> Save() const;
  // Continues from the snapshot, as if the last step had just been. Nothing may run. Returns all
  // errors of the snapshot; if there are any, nothing has changed.
  [[nodiscard]] std::vector<fsm::SnapshotFault> Restore(const ManagerSnapshot& saved);

 private:
  Result<const Entry*> Lookup(std::string_view skill) const;
  Result<Run*> Running(std::string_view skill) const;
  Result<> Free(const Run& run, const std::vector<std::string>& parts) const;
  Result<> Allowed(std::string_view skill) const;
  Result<> Begin(std::unique_ptr<Run> run, const Values& parameters, Origin origin);
  void Keep(std::unique_ptr<Run> run);
  void Remove(std::string_view skill);

  const std::vector<Entry> entries_;
  std::vector<std::unique_ptr<Run>> runs_;
  std::uint64_t last_number_ = 0;  // of a run
  std::function<void(const Run&)> removal_;
  std::function<void(const Run&, const Change&)> changed_;
  std::optional<Time> last_;
  bool in_step_ = false;
};

}  // namespace musher::skill
