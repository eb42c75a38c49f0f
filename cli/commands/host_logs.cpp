#include "musher/cli/commands/host_logs.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "musher/base/words.hpp"
#include "musher/cli/console/wall_time.hpp"
#include "musher/controller/process/host_processes.hpp"

namespace musher::cli {
namespace {

constexpr std::size_t kMostLines = 100'000;   // of one log
constexpr std::int64_t kConnectMarginS = 10;  // a connection takes so long before it reads
// -a: long messages, too.
constexpr const char* kJournal =
    "journalctl -q --no-pager -a -o json --output-fields=MESSAGE,_SYSTEMD_UNIT,UNIT";

// journalctl -q says nothing of a journal that its user may not read. What the journal ends with is
// printed before a log is read.
constexpr const char* kJournalFacts = R"sh(
readable= denied=
for journal in /run/log/journal /var/log/journal; do
  journal=$journal/$(cat /etc/machine-id)
  [ -e "$journal" ] || continue
  [ -r "$journal/system.journal" ] && readable=1 || denied=1
done
[ -z "$denied" ] || [ -n "$readable" ] || echo "musher-denied $(id -un)"
journalctl -q --no-pager -o json --output-fields=_BOOT_ID -n 1 | sed 's/^/musher-end /'
)sh";
constexpr std::string_view kJournalDenied = "musher-denied ";
constexpr std::string_view kJournalEnd = "musher-end ";

std::string TextOf(const nlohmann::json& field) {
  if (field.is_string()) return field.get<std::string>();
  std::string text;  // of bytes that are no UTF-8
  if (!field.is_array()) return text;
  for (const auto& byte : field) {
    if (byte.is_number_unsigned()) text.push_back(static_cast<char>(byte.get<unsigned>()));
  }
  return text;
}

// Reckoned back there, by the clock of that host.
std::string SinceOption(std::int64_t since_ns, std::int64_t margin_s) {
  const std::int64_t ago_s = std::max<std::int64_t>(WallNow() - since_ns, 0) / 1'000'000'000;
  return "--since=-" + std::to_string(ago_s + margin_s) + "s";
}

std::string ReadScript(const HostLog& log, std::int64_t since_ns, std::size_t lines) {
  std::string script = kJournal;
  if (since_ns != 0) script += " " + SinceOption(since_ns, 1);
  // The newest first: they are there if the time is too short for all.
  return script + " -r -n " +
         std::to_string(lines == 0 ? kMostLines : std::min(lines, kMostLines)) + " -u " + log.unit +
         "\n";
}

std::string CursorOf(const nlohmann::json& fields) {
  return fields.is_object() && fields.contains("__CURSOR") ? TextOf(fields["__CURSOR"]) : "";
}

// What is wrong with the lines of this host; empty: nothing.
std::string JournalTrouble(const HostConfig& host, const HostAnswer& answer) {
  if (answer.cut) {
    return answer.trouble +
           ": the older lines of its logs are missing; ask for fewer of them by "
           "-n or --since";
  }
  if (!answer.trouble.empty()) return answer.trouble;
  for (const std::string& line : answer.lines) {
    if (!line.starts_with(kJournalDenied)) continue;
    const std::string user = line.substr(kJournalDenied.size());
    return "host " + host.name + " (" + host.Login() + "): user " + user +
           " may not read its journal: lines are missing; permit it there by `usermod -aG "
           "systemd-journal " +
           user + "`";
  }
  return {};
}

}  // namespace

std::optional<HostLog> HostLogOf(const MachineFiles& files, const std::string& actuator) {
  const auto index = files.config ? files.config->IndexOf(actuator) : std::nullopt;
  if (!index) return std::nullopt;
  const HostConfig* host = files.config->HostOf(files.config->actuators[*index].host);
  if (host == nullptr) return std::nullopt;
  return HostLog{actuator, host, UnitNameOf(files.config->name, actuator)};
}

ReadHostLogs ReadLogsOf(const std::vector<HostLog>& logs, std::int64_t since_ns, std::size_t lines,
                        Duration within) {
  std::vector<HostQuery> queries;
  for (const HostLog& log : logs) {
    const auto same = std::find_if(queries.begin(), queries.end(),
                                   [&](const HostQuery& query) { return query.host == log.host; });
    HostQuery& query =
        same != queries.end() ? *same : queries.emplace_back(HostQuery{log.host, kJournalFacts});
    query.script += ReadScript(log, since_ns, lines);
  }
  const std::vector<HostAnswer> answers = QueryHosts(queries, within);
  ReadHostLogs read;
  read.entries.resize(logs.size());
  for (std::size_t i = 0; i < queries.size(); ++i) {
    const HostAnswer& answer = answers[i];
    JournalPosition& position = read.positions[queries[i].host];
    std::map<std::string, std::vector<WrittenLine>> by_unit;  // the newest first
    for (const std::string& text : answer.lines) {
      if (text.starts_with(kJournalEnd)) {
        position.cursor =
            CursorOf(nlohmann::json::parse(text.substr(kJournalEnd.size()), nullptr, false));
      }
      auto one = ParseJournalLine(text);
      if (!one) continue;
      one->line.written_ns -= answer.clock_offset_ns.value_or(0);
      position.shown.insert(std::move(one->cursor));
      by_unit[one->unit].push_back(std::move(one->line));
    }
    for (std::size_t log = 0; log < logs.size(); ++log) {
      if (logs[log].host != queries[i].host) continue;
      std::vector<WrittenLine>& of_one = by_unit[logs[log].unit];
      const bool all = lines == 0 || lines > kMostLines;
      if (all && of_one.size() >= kMostLines && !answer.cut) {
        read.troubles.push_back("host " + logs[log].host->name + " (" + logs[log].host->Login() +
                                "): of " + logs[log].actuator + " only the newest " +
                                std::to_string(kMostLines) +
                                " lines are read, older ones are missing; all are in `ssh " +
                                logs[log].host->Login() + " journalctl -u " + logs[log].unit + "`");
      }
      std::reverse(of_one.begin(), of_one.end());
      read.entries[log] = LogEntriesOf(logs[log].actuator, of_one);
    }
    if (std::string trouble = JournalTrouble(*queries[i].host, answer); !trouble.empty()) {
      read.troubles.push_back(std::move(trouble));
    }
  }
  return read;
}

std::string FollowScript(const std::vector<HostLog>& logs, const std::string& cursor,
                         std::int64_t since_ns) {
  std::string script = std::string("exec ") + kJournal + " -f";
  // Not --after-cursor: that leaves out the first line if the entry is of no unit that is shown.
  script += " --no-tail " + (cursor.empty() ? SinceOption(since_ns, kConnectMarginS)
                                            : "--cursor=" + ShellWord(cursor));
  for (const HostLog& log : logs) script += " -u " + log.unit;
  return script + "\n";
}

std::optional<JournalLine> ParseJournalLine(const std::string& json) {
  const auto fields = nlohmann::json::parse(json, nullptr, false);
  if (!fields.is_object() || !fields.contains("MESSAGE")) return std::nullopt;
  JournalLine line;
  line.cursor = CursorOf(fields);
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
