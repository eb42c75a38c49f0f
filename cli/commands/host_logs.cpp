#include "musher/cli/commands/host_logs.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "musher/cli/console/wall_time.hpp"
#include "musher/controller/process/host_processes.hpp"

namespace musher::cli {
namespace {

constexpr Duration kWithin = Milliseconds(10'000);
constexpr std::size_t kMostLines = 100'000;  // of one log
constexpr const char* kJournal =
    "journalctl -q --no-pager -o json --output-fields=MESSAGE,_SYSTEMD_UNIT,UNIT";

std::string TextOf(const nlohmann::json& field) {
  if (field.is_string()) return field.get<std::string>();
  std::string text;  // of bytes that are no UTF-8
  if (!field.is_array()) return text;
  for (const auto& byte : field) {
    if (byte.is_number_unsigned()) text.push_back(static_cast<char>(byte.get<unsigned>()));
  }
  return text;
}

std::string ReadScript(const HostLog& log, std::int64_t since_ns, std::size_t lines) {
  std::string script = kJournal;
  if (since_ns != 0) {  // by the clock of that host
    const std::int64_t ago_s = std::max<std::int64_t>(WallNow() - since_ns, 0) / 1'000'000'000 + 1;
    script += " --since=-" + std::to_string(ago_s) + "s";
  }
  return script + " -n " + std::to_string(lines == 0 ? kMostLines : std::min(lines, kMostLines)) +
         " -u " + log.unit + "\n";
}

}  // namespace

std::optional<HostLog> HostLogOf(const MachineFiles& files, const std::string& actuator) {
  const auto index = files.config ? files.config->IndexOf(actuator) : std::nullopt;
  if (!index) return std::nullopt;
  const HostConfig* host = files.config->HostOf(files.config->actuators[*index].host);
  if (host == nullptr) return std::nullopt;
  return HostLog{actuator, host, UnitNameOf(files.config->name, actuator)};
}

ReadHostLogs ReadLogsOf(const std::vector<HostLog>& logs, std::int64_t since_ns,
                        std::size_t lines) {
  std::vector<HostQuery> queries;
  for (const HostLog& log : logs) {
    const auto same = std::find_if(queries.begin(), queries.end(),
                                   [&](const HostQuery& query) { return query.host == log.host; });
    HostQuery& query =
        same != queries.end() ? *same : queries.emplace_back(HostQuery{log.host, ""});
    query.script += ReadScript(log, since_ns, lines);
  }
  const std::vector<HostAnswer> answers = QueryHosts(queries, kWithin);
  ReadHostLogs read;
  for (const HostLog& log : logs) {
    std::vector<LogEntry>& entries = read.entries.emplace_back();
    LogLines reader(log.actuator);
    for (std::size_t i = 0; i < queries.size(); ++i) {
      if (queries[i].host != log.host) continue;
      for (const std::string& text : answers[i].lines) {
        auto one = ParseJournalLine(text);
        if (!one || one->unit != log.unit) continue;
        one->line.written_ns -= answers[i].clock_offset_ns.value_or(0);
        entries.push_back(reader.Take(one->line));
      }
    }
  }
  for (const HostAnswer& answer : answers) {
    if (!answer.trouble.empty()) read.troubles.push_back(answer.trouble);
  }
  return read;
}

std::string FollowScript(const std::vector<HostLog>& logs) {
  std::string script = std::string("exec ") + kJournal + " -f -n 0";
  for (const HostLog& log : logs) script += " -u " + log.unit;
  return script + "\n";
}

std::optional<JournalLine> ParseJournalLine(const std::string& json) {
  const auto fields = nlohmann::json::parse(json, nullptr, false);
  if (!fields.is_object() || !fields.contains("MESSAGE")) return std::nullopt;
  JournalLine line;
  // A line of systemd itself has the unit that it is about.
  const std::string about = fields.contains("UNIT") ? "UNIT" : "_SYSTEMD_UNIT";
  if (fields.contains(about)) line.unit = TextOf(fields[about]);
  line.line.text = TextOf(fields["MESSAGE"]);
  std::replace(line.line.text.begin(), line.line.text.end(), '\n', ' ');
  if (const auto time = fields.find("__REALTIME_TIMESTAMP");
      time != fields.end() && time->is_string()) {
    line.line.written_ns = std::strtoll(time->get<std::string>().c_str(), nullptr, 10) * 1000;
  }
  return line;
}

}  // namespace musher::cli
