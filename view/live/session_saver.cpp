#include "musher/view/live/session_saver.hpp"

#include <iterator>
#include <utility>

#include "musher/base/log.hpp"

namespace musher::view {

SessionSaver::SessionSaver(transport::EventLoop& loop, Write write, Duration answer_within)
    : loop_(loop),
      write_(std::move(write)),
      answer_within_(answer_within),
      disk_(loop, {.name = "view-sessions"}) {}

void SessionSaver::Save(std::vector<http::KeptSession> sessions, std::int64_t wall_ms, Then then) {
  if (!write_) {
    if (then) then(Ok());
    return;
  }
  if (then) Await(std::move(then));
  disk_.Do(
      "sessions",
      [write = write_, sessions = std::move(sessions), wall_ms] {
        return write(sessions, wall_ms);
      },
      [this](const Result<>& kept) { OnKept(kept); });
}

void SessionSaver::Await(Then then) {
  waiting_.emplace_back();
  const auto waiting = std::prev(waiting_.end());
  waiting->then = std::move(then);
  waiting->limit = loop_.At(loop_.Now() + answer_within_, [this, waiting] {
    const Then late = std::move(waiting->then);
    waiting_.erase(waiting);
    late(Error{kCodeTimeout, "the disk does not answer"});
  });
}

// Of the last write, which has the sessions of all before it.
void SessionSaver::OnKept(const Result<>& kept) {
  if (!kept && !std::exchange(failed_, true)) {
    WriteLog(LogLevel::kWarning, "musher-view",
             "the logins on disk are not those of now: " + kept.error().message);
  }
  for (const WaitingAnswer& waiting : std::exchange(waiting_, {})) waiting.then(kept);
}

}  // namespace musher::view
