#pragma once
// The goals that a plan has sent to its robots, in a file, so that the process after one that was
// killed cancels them: a goal outlives its client, and its robot goes on.
//
//   goals ── Save() ──▶ file ── process is killed ──▶ Found() of the next one
//
// A file of any age counts, also after a restart of the computer: its robots may be other
// computers, and an id names one goal for ever.
//
// Threads: one at a time.

#include <map>
#include <optional>
#include <string>
#include <utility>

#include "musher/base/result.hpp"
#include "musher/transport/action_goals.hpp"

namespace musher::skills {

class SavedGoals {
 public:
  using Goals = std::map<transport::GoalId, std::string>;  // the robot of each

  // An empty `file`: nothing is saved, and nothing found.
  explicit SavedGoals(std::string file) : file_(std::move(file)) {}

  // What the process before has saved last. Fails with the reason when it cannot be read.
  Result<Goals> Found() const;

  // Writes when they have changed; without goals there is no file. Fails with the reason when it
  // cannot; once for each reason.
  Result<> Save(const Goals& goals);

 private:
  const std::string file_;
  std::optional<Goals> saved_;  // nullopt: the file is that of the process before
  std::string fault_;
};

}  // namespace musher::skills
