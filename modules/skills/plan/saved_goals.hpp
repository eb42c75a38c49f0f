#pragma once
// The goals that a plan has sent to its robots, in a file, so that the process after one that was
// killed cancels them: a goal outlives its client, and its robot goes on.
//
//   goals ── Save() ──▶ file ── process is killed ──▶ Found() of the next one
//
// A disk that takes nothing is tried again every kRetry, as often as the caller calls Save().
//
// A file of any age counts, also after a restart of the computer: its robots may be other
// computers, and an id names one goal for ever.
//
// Time is an argument. Threads: one at a time.

#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "musher/base/result.hpp"
#include "musher/base/saved_file.hpp"
#include "musher/base/time.hpp"
#include "musher/transport/action_goals.hpp"

namespace musher::skills {

class SavedGoals {
 public:
  using Goals = std::map<transport::GoalId, std::string>;  // the robot of each

  // An empty `file`: nothing is saved, and nothing found.
  explicit SavedGoals(std::string file) : file_(std::move(file)), on_disk_(file_) {}

  // What the process before has saved last. Fails with the reason when it cannot be read.
  Result<Goals> Found() const;

  static constexpr Duration kRetry = std::chrono::seconds(1);

  // Writes when they have changed, and when the last attempt has failed and is kRetry ago; without
  // goals there is no file. Fails with the reason when it cannot; once for each reason.
  Result<> Save(const Goals& goals, Time now);
  // Whether the last attempt has failed.
  bool failed() const { return !fault_.empty(); }

 private:
  const std::string file_;
  SavedFile on_disk_;
  std::optional<Goals> saved_;  // the last attempt; nullopt: the file is that of the process before
  Time retry_at_{};             // of an attempt that has failed
  std::string fault_;           // of the last attempt
};

}  // namespace musher::skills
