#pragma once
// The skills that run, in a file, so that the process after a crash knows of them: it fails them
// with the reason, or goes on with them.
//
//   steps ── Save() ──▶ file ── process is killed ──▶ Restore() of the next one
//
// Written when a run changes its state or ends, and else once a second; a process that is killed
// loses that much. Only what runs is in it. Threads: one at a time. Times are the machine's.

#include <optional>
#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"
#include "musher/behavior/skill/manager.hpp"

namespace musher {

class SavedSkills {
 public:
  explicit SavedSkills(std::string file) : file_(std::move(file)) {}

  // Fails with the reason when it cannot be written; once for each reason.
  Result<> Save(const skill::Manager& manager, Time now);

  // What ran in the process before, in a manager that has run nothing: to go on with, or, without
  // `continues`, as runs that have failed. Returns a line for each of them. Fails for a file that
  // cannot be read, or does not fit these skills; then nothing has changed.
  Result<std::vector<std::string>> Restore(skill::Manager& manager, bool continues);

 private:
  const std::string file_;
  // The states of the runs that were written last. Nothing at first: what a process before has left
  // in the file is replaced by the first Save().
  std::optional<std::string> shown_;
  std::optional<Time> written_at_;
  std::string fault_;
};

}  // namespace musher
