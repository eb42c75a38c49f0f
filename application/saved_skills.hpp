#pragma once
// The skills that run, in a file, so that the process after a crash knows of them: it fails them
// with the reason, or goes on with them.
//
//   steps ── Save() ──▶ file ── process is killed ──▶ Restore() of the next one
//
// Written when a run changes its state or ends, and else once a second; a process that is killed
// loses that much. Only what runs is in it.
//
// A robot goes on with what it did a moment ago, and not with what it did before it was switched
// off, or long ago: only with a file of the same boot of its computer that was written kMostAge ago
// at most, when it is read and again when the first step follows, and without an emergency stop in
// between, which would have cancelled it: without one, and the release of one, that the process
// before did not know. What was restored and has made no step keeps its time in
// the file, whatever states its process passes through.
//
// Threads: one at a time. Times are the machine's, but HostTime.

#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/base/saved_file.hpp"
#include "musher/base/time.hpp"
#include "musher/behavior/skill/manager.hpp"

namespace musher {

// A time of this computer, whatever clock the machine has.
struct HostTime {
  std::string host;       // HostId(): one boot of one computer; empty: unknown
  Duration since_boot{};  // also while it slept
};
HostTime HostTimeNow();

class SavedSkills {
 public:
  static constexpr Duration kMostAge = std::chrono::minutes(1);

  // When the file was written, and what its process knew then.
  struct Written {
    HostTime at;
    std::set<std::string> stops;  // see NoteStop()
  };

  explicit SavedSkills(std::string file, std::function<HostTime()> host_now = HostTimeNow)
      : file_(std::move(file)),
        saved_(file_, SavedFile::AfterFailure::kRemoved),
        host_now_(std::move(host_now)) {}

  // Fails with the reason when it cannot be written; once for each reason.
  Result<> Save(const skill::Manager& manager, Time now);

  // What ran in the process before, in a manager that has run nothing: to go on with, or, without
  // `continues` and from a file of another boot or an old one, as runs that have failed. Returns a
  // line for each of them, with the reason. Fails for a file that cannot be read, or does not fit
  // these skills; then nothing has changed.
  Result<std::vector<std::string>> Restore(skill::Manager& manager, bool continues);

  // A sample of an emergency stop was received, or of its release. The last 256 or so are kept: one
  // that is forgotten counts as another one. No clock says which is the later one: that of its
  // writer may be behind.
  void NoteStop(std::uint64_t id, bool engaged);

  // Called before steps: why what was restored must not go on by now; empty: it may. From then on
  // the runs are those of this process.
  std::string TakeOver();

 private:
  const std::string file_;
  // An old one would say that what has ended goes on. Its removal is possible on a full disk, too.
  SavedFile saved_;
  const std::function<HostTime()> host_now_;
  // The states of the runs that were written last. Nothing at first: what a process before has left
  // in the file is replaced by the first Save().
  std::optional<std::string> shown_;
  std::optional<Time> written_at_;
  std::optional<Written> restored_;  // by the process before
  std::set<std::string> stops_;      // "17+": engaged; "17-": released
  std::string fault_;
};

}  // namespace musher
