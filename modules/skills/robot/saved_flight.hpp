#pragma once
// Where a flyer was in the air, in a file, so that the process after one that was killed holds it
// there: else the wind has it until a skill moves it.
//
//   in the air ── Save() ──▶ file ── process is killed ──▶ Found() of the next one
//
// Only a file of the same boot of its computer that is kMostAge old at most counts: after that a
// person may have taken the flyer. Metres; the frame of its odometry. Threads: one at a time.

#include <functional>
#include <optional>
#include <string>

#include "musher/application/saved_skills.hpp"
#include "musher/base/saved_file.hpp"
#include "musher/navigation/pose.hpp"

namespace musher::skills {

class SavedFlight {
 public:
  static constexpr Duration kMostAge = std::chrono::seconds(10);

  // An empty `file`: nothing is saved, and nothing found.
  explicit SavedFlight(std::string file, std::function<HostTime()> host_now = HostTimeNow)
      : file_(std::move(file)), saved_(file_), host_now_(std::move(host_now)) {}

  // Where the process before had it in the air a moment ago. Nullopt: it had not, or the file
  // cannot be read.
  std::optional<navigation::Point> Found() const;

  // Where it is in the air; nullopt: it is not. Writes once a second at most. Fails with the reason
  // when it cannot; once for each reason.
  Result<> Save(const std::optional<navigation::Point>& place);

 private:
  const std::string file_;
  SavedFile saved_;
  const std::function<HostTime()> host_now_;
  std::optional<Duration> written_at_;  // since the boot; nullopt: there is no file of this process
  bool removed_ = false;                // nor one of the process before
  std::string fault_;
};

}  // namespace musher::skills
