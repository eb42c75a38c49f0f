#include "musher/cli/machine/command_times.hpp"

#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "musher/controller/journal/journal_reader.hpp"
#include "musher/lifecycle/event_name.hpp"

namespace musher::cli {
namespace {

// The command of an entry of such an event; nullopt: it names none.
std::optional<CommandTime> CommandOf(const JournalEntry& entry, const std::string& journal) {
  const bool overdue = entry.event == NameOf(EventName::kCommandOverdue);
  if (!overdue && entry.event != NameOf(EventName::kCommandDone)) return std::nullopt;
  const auto data = nlohmann::json::parse(entry.data, nullptr, false);
  const auto arguments = data.is_object() ? data.find("arguments") : data.end();
  if (arguments == data.end() || !arguments->is_object()) return std::nullopt;
  const auto target = arguments->find("target");
  const auto took = arguments->find("took_ms");
  if (target == arguments->end() || !target->is_string()) return std::nullopt;
  if (took == arguments->end() || !took->is_number()) return std::nullopt;
  return CommandTime{entry.actuator, State(target->get<std::string>()),
                     entry.wall_ns,  took->get<double>(),
                     overdue,        journal};
}

}  // namespace

Result<CommandTimes> ReadCommandTimes(const std::string& journal, std::int64_t since_wall_ns) {
  const auto read = ReadJournal(journal, since_wall_ns, SIZE_MAX);
  if (!read) return read.error();
  CommandTimes times;
  times.damage = read.value().damage;
  for (const JournalEntry& entry : read.value().entries) {
    if (auto command = CommandOf(entry, journal)) times.commands.push_back(*std::move(command));
  }
  return times;
}

}  // namespace musher::cli
