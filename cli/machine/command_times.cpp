#include "musher/cli/machine/command_times.hpp"

#include <algorithm>
#include <initializer_list>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "musher/controller/journal/journal_reader.hpp"
#include "musher/lifecycle/event_name.hpp"
#include "musher/lifecycle/state.hpp"

namespace musher::cli {
namespace {

// An argument of its record; null: there is none.
nlohmann::json ArgumentOf(const JournalEntry& entry, const char* name) {
  const auto data = nlohmann::json::parse(entry.data, nullptr, false);
  const auto arguments = data.is_object() ? data.find("arguments") : data.end();
  if (arguments == data.end() || !arguments->is_object()) return nullptr;
  const auto argument = arguments->find(name);
  return argument == arguments->end() ? nlohmann::json() : *argument;
}

// The command of an entry of such an event; nullopt: it names none.
std::optional<CommandTime> CommandOf(const JournalEntry& entry, const std::string& journal) {
  const bool overdue = entry.event == NameOf(EventName::kCommandOverdue);
  if (!overdue && entry.event != NameOf(EventName::kCommandDone)) return std::nullopt;
  const auto target = ArgumentOf(entry, "target");
  const auto took = ArgumentOf(entry, "took_ms");
  if (!target.is_string() || !took.is_number()) return std::nullopt;
  return CommandTime{entry.actuator, State(target.get<std::string>()),
                     entry.wall_ns,  took.get<double>(),
                     overdue,        journal};
}

// A unit that its controller finds running has begun before.
bool IsFoundRunning(const JournalEntry& started) {
  return started.message.find(" already ") != std::string::npos;
}

// Finds the SetUps in the entries of a journal.
class SetUps {
 public:
  explicit SetUps(const std::string& journal) : journal_(journal) {}

  // The one that has ended with this entry, oldest entries first; nullopt: none.
  std::optional<CommandTime> Take(const JournalEntry& entry) {
    if (entry.event == NameOf(EventName::kProcessStarted)) {
      begun_.erase(entry.actuator);
      if (!IsFoundRunning(entry)) begun_[entry.actuator] = {entry.epoch, entry.steady_ns};
      return std::nullopt;
    }
    const bool overdue = IsOneOf(
        entry, {EventName::kSetUpTimeout, EventName::kNotAnnounced, EventName::kNodeNotDiscovered});
    const bool done = IsOneOf(entry, {EventName::kActuatorPresent});
    const bool gone = IsOneOf(entry, {EventName::kProcessExited, EventName::kProcessExitAssumed});
    const auto begun = begun_.find(entry.actuator);
    if (!(overdue || done || gone) || begun == begun_.end()) return std::nullopt;
    const Begun at = begun->second;
    begun_.erase(begun);
    // Times of two controllers are not compared.
    if (gone || at.epoch != entry.epoch || entry.steady_ns <= at.steady_ns) return std::nullopt;
    constexpr double kNsOfMs = 1e6;
    double took_ms = static_cast<double>(entry.steady_ns - at.steady_ns) / kNsOfMs;
    if (const auto limit = ArgumentOf(entry, "within_ms"); overdue && limit.is_number()) {
      took_ms = limit.get<double>();
    }
    return CommandTime{entry.actuator, State(kSetUp), entry.wall_ns, took_ms, overdue, journal_};
  }

 private:
  struct Begun {
    Epoch epoch = 0;
    std::int64_t steady_ns = 0;
  };

  static bool IsOneOf(const JournalEntry& entry, std::initializer_list<EventName> events) {
    return std::ranges::any_of(events,
                               [&](EventName event) { return entry.event == NameOf(event); });
  }

  const std::string& journal_;
  std::map<std::string, Begun> begun_;  // by actuator
};

}  // namespace

std::vector<CommandTime> CommandTimesOf(const std::vector<JournalEntry>& entries,
                                        const std::string& journal) {
  std::vector<CommandTime> times;
  SetUps set_ups(journal);
  for (const JournalEntry& entry : entries) {
    if (auto command = CommandOf(entry, journal)) times.push_back(*std::move(command));
    if (auto set_up = set_ups.Take(entry)) times.push_back(*std::move(set_up));
  }
  return times;
}

Result<CommandTimes> ReadCommandTimes(const std::string& journal, std::int64_t since_wall_ns) {
  const auto read = ReadJournal(journal, since_wall_ns, SIZE_MAX);
  if (!read) return read.error();
  CommandTimes times;
  times.damage = read.value().damage;
  times.commands = CommandTimesOf(read.value().entries, journal);
  return times;
}

}  // namespace musher::cli
