#include "musher/test/support/musher.hpp"

#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <utility>

#include "musher/test/support/json_schema.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/wait.hpp"

namespace musher::testing {
namespace {

constexpr auto kLimit = std::chrono::seconds(120);
constexpr int kNoController = 3;

// Without what differs each time, or is not known to `status --follow`.
nlohmann::json Comparable(nlohmann::json status) {
  status.erase("uptime_s");
  status.erase("since");
  return status;
}

}  // namespace

std::vector<std::string> Command(std::vector<std::string> words) {
  words.insert(words.begin(), BinDir() + "/musher");
  return words;
}

Ended Musher(std::vector<std::string> words) {
  Ended ended = RunToEnd(Command(words));
  CheckDocuments(words, ended.out);
  return ended;
}

nlohmann::json Json(const std::string& text) {
  auto json = nlohmann::json::parse(text, nullptr, false);
  EXPECT_FALSE(json.is_discarded()) << text;
  return json;
}

nlohmann::json Status() {
  const Ended status = Musher({"status", "--json"});
  return status.exit == 0 ? Comparable(Json(status.out)) : nlohmann::json();
}

StatusStream::~StatusStream() {
  if (!watch_) return;
  watch_->Signal(SIGINT);
  watch_->Wait();
}

nlohmann::json StatusStream::Await(const IsSo& is_so, std::source_location caller) {
  const Time deadline = In(kLimit);
  while (!latest_.is_object() || !is_so(latest_)) {
    if (Next(deadline)) continue;
    ADD_FAILURE_AT(caller.file_name(), static_cast<int>(caller.line()))
        << "the awaited status has not come; the last one is " << latest_ << " " << trouble_;
    break;
  }
  return latest_;
}

bool StatusStream::Next(Time deadline) {
  while (std::chrono::steady_clock::now() < deadline) {
    if (!watch_) watch_.emplace(Command({"status", "--follow", "--json"}));
    if (const auto line = watch_->NextLine(deadline)) {
      auto printed = Json(*line);
      if (printed.contains("machine")) {
        latest_ = Comparable(std::move(printed));
        return true;
      }
      trouble_ = *line;  // there is no controller, or it is lost
    } else if (std::chrono::steady_clock::now() < deadline) {
      const Ended ended = watch_->Wait();
      watch_.reset();
      trouble_ = ended.err;
      if (ended.exit != kNoController) return false;
    }
  }
  return false;
}

nlohmann::json AwaitStatus(const IsSo& is_so, std::source_location caller) {
  return StatusStream().Await(is_so, caller);
}

bool AllHaveArrived(const nlohmann::json& status) {
  for (const auto& actuator : status["actuators"]) {
    if (actuator["presence"] != "present" || !actuator["target"].is_null()) return false;
    const bool may_go_up = !status["emergency_stop"]["engaged"].get<bool>();
    if (may_go_up && actuator["state"] != status["state"]) return false;
  }
  return status["target"].is_null();
}

IsSo AllHaveArrivedIn(const std::string& state) {
  return [state](const nlohmann::json& status) {
    return status["state"] == state && AllHaveArrived(status);
  };
}

Ended UpDetached(const std::string& config) {
  Ended up = Musher({"up", config, "--detach"});
  if (up.exit == 0) AwaitStatus(AllHaveArrived);
  return up;
}

}  // namespace musher::testing
