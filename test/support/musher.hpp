#pragma once
// The `musher` program as a user runs it, and the status of the machine that it prints, in the
// domain and the namespace of the environment.

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <source_location>
#include <string>
#include <vector>

#include "musher/test/support/process.hpp"

namespace musher::testing {

// `musher` with these words, for a Process.
std::vector<std::string> Command(std::vector<std::string> words);
// Runs it to its end.
Ended Musher(std::vector<std::string> words);

nlohmann::json Json(const std::string& text);
// The machine's status; null when there is no controller.
nlohmann::json Status();

using IsSo = std::function<bool(const nlohmann::json& status)>;

// The machine's statuses, as `musher status --follow --json` prints them, each with its change. The
// program is started by the first Await(), and again if it has found no controller; it ends with
// this object.
//
// The first status is not older than the end of any command before, so it needs no other proof that
// the machine has obeyed. A stream that is kept over a command also has the statuses before: what
// is awaited then must not hold in those.
class StatusStream {
 public:
  // The status that the last Await() has returned, or the first one after it that is so. Fails the
  // test when there is none for 20 s, and returns the last one.
  nlohmann::json Await(const IsSo& is_so,
                       std::source_location caller = std::source_location::current());

  StatusStream() = default;
  // As Ctrl-C ends it, so that the controller need not wait for a lost reader.
  ~StatusStream();
  StatusStream(const StatusStream&) = delete;
  StatusStream& operator=(const StatusStream&) = delete;

 private:
  // Reads the next status, also if it is none; false: none before the deadline, or a wrong command.
  bool Next(Time deadline);

  std::optional<Process> watch_;
  nlohmann::json latest_;
  std::string trouble_;  // that `watch_` has printed last
};

// The first status from now on that is so.
nlohmann::json AwaitStatus(const IsSo& is_so,
                           std::source_location caller = std::source_location::current());

// Every actuator is present and at rest, and in the machine's state if it may go up.
bool AllHaveArrived(const nlohmann::json& status);
// The same in that state.
IsSo AllHaveArrivedIn(const std::string& state);

// Up, and stage 2, too, has come as far as the machine is: a switch up is refused while an actuator
// is still on its way.
Ended UpDetached(const std::string& config);

}  // namespace musher::testing
