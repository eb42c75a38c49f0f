#include "musher/cli/machine/kept_searches.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <set>
#include <sstream>
#include <system_error>
#include <utility>

#include "musher/base/checksum.hpp"
#include "musher/base/files.hpp"
#include "musher/base/host.hpp"
#include "musher/base/own_folder.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/base/version.hpp"
#include "musher/controller/storage/private_folder.hpp"
#include "musher/ota/signature.hpp"

namespace musher::cli {
namespace {

namespace fs = std::filesystem;
using search::ProvedTask;

constexpr std::string_view kKeptHeader = "musher prove 2\n";
constexpr std::string_view kOfStart = "-";  // instead of a state
constexpr const char* kKeptDamaged = "it is damaged";

std::string KeptSum(std::string_view content) {
  return fmt::format("sum {:016x}\n", Fnv1a(content));
}

std::string KeptLine(const ProvedTask& search) {
  const search::ProofTask& task = search.task;
  const search::Figures& figures = search.figures;
  std::string line = fmt::format(
      "{} {} {} {} {} {} {:.0f} {}", task.IsStart() ? kOfStart : task.from.name(),
      task.IsStart() ? kOfStart : task.to.name(), task.faults, figures.nodes, figures.transitions,
      figures.leaves, figures.seconds * 1000, search.rule_coverage.size());
  for (const RuleCoverage& rule : search.rule_coverage) {
    line += fmt::format(" {} {} {}", rule.states, rule.condition, rule.forbidden);
  }
  line += fmt::format(" {}", search.timed_coverage.size());
  for (const TimedRuleCoverage& rule : search.timed_coverage) {
    line += fmt::format(" {} {}", rule.begun, rule.met);
  }
  return line + "\n";
}

// nullopt: it is not as KeptLine() makes it.
std::optional<ProvedTask> SearchOfLine(const std::string& line, const RuleCounts& rules) {
  std::istringstream words(line);
  std::string from;
  std::string to;
  double took_ms = 0;
  std::size_t kept_rules = 0;
  ProvedTask search;
  words >> from >> to >> search.task.faults >> search.figures.nodes >> search.figures.transitions >>
      search.figures.leaves >> took_ms >> kept_rules;
  if (!words || kept_rules != rules.stable) return std::nullopt;
  search.rule_coverage.resize(rules.stable);
  for (RuleCoverage& rule : search.rule_coverage) {
    words >> rule.states >> rule.condition >> rule.forbidden;
  }
  words >> kept_rules;
  if (!words || kept_rules != rules.timed) return std::nullopt;
  search.timed_coverage.resize(rules.timed);
  for (TimedRuleCoverage& rule : search.timed_coverage) words >> rule.begun >> rule.met;
  if (!words) return std::nullopt;
  if (from != kOfStart) search.task.from = State(from);
  if (to != kOfStart) search.task.to = State(to);
  search.figures.pairs = 1;
  search.figures.seconds = took_ms / 1000;
  search.finished = search.earlier = true;
  return search;
}

bool HasTask(const std::vector<ProvedTask>& searches, const search::ProofTask& task) {
  return std::ranges::find(searches, task, &ProvedTask::task) != searches.end();
}

// The program, and Musher's libraries where it is built with shared ones.
std::set<std::string> FilesOfThisProgram() {
  std::set<std::string> files = {"/proc/self/exe"};
  std::istringstream maps(ReadFile("/proc/self/maps"));
  for (std::string line; std::getline(maps, line);) {
    const std::size_t path = line.find('/');
    if (path == std::string::npos) continue;
    const fs::path file = line.substr(path);
    if (file.filename().string().starts_with("libmusher")) files.insert(file.string());
  }
  return files;
}

// Empty: this user has none.
fs::path FolderOfKeptSearches() {
  const auto absolute = [](const char* variable) -> fs::path {
    const char* value = std::getenv(variable);  // NOLINT(concurrency-mt-unsafe)
    return value != nullptr && value[0] == '/' ? value : "";
  };
  fs::path cache = absolute("XDG_CACHE_HOME");
  if (cache.empty() && !absolute("HOME").empty()) cache = absolute("HOME") / ".cache";
  return cache.empty() ? fs::path() : cache / "musher" / "prove";
}

// Who can change the folder, or what it is made in, decides what counts as proved. So root makes
// none in the home of a user either.
Result<> CheckOnlyOurs(const fs::path& folder) {
  const fs::path musher = folder.parent_path();
  fs::path made_in = musher.parent_path();
  std::error_code ignored;
  while (!fs::exists(made_in, ignored) && made_in.has_relative_path()) {
    made_in = made_in.parent_path();
  }
  for (const fs::path& one : {made_in, musher, folder}) {
    if (CheckOwnFolder(one.string())) continue;
    return Error{kCodePermissionDenied, "another user can write to " + one.string() +
                                            "; name a folder of your own in XDG_CACHE_HOME"};
  }
  return Ok();
}

// Result: all of it. Error: why it does not count. nullopt: there is none.
Result<std::optional<std::string>> ReadOwnFile(const std::string& path) {
  const UniqueFd file = OpenRegular(path);
  if (!file.valid()) {
    if (errno == ENOENT || errno == ENOTDIR) return std::optional<std::string>();
    if (errno == EINVAL) return Error{kCodeFailed, "it is no regular file"};
    return SystemError("it can't be read");
  }
  std::string text;
  std::array<char, 4096> part{};
  while (true) {
    const ssize_t size = read(file.get(), part.data(), part.size());
    if (size < 0 && errno == EINTR) continue;
    if (size < 0) return SystemError("it can't be read");
    if (size == 0) return std::optional(text);
    text.append(part.data(), static_cast<std::size_t>(size));
  }
}

}  // namespace

Result<std::string> ProofKey(const MachineConfig& config, const search::ProofOptions& proof) {
  ota::Sha256 sha;
  const auto add = [&sha](std::string_view text) {
    sha.Add(std::to_string(text.size()) + ":");
    sha.Add(text);
  };
  add(Version());
  for (const std::string& file : FilesOfThisProgram()) {
    const std::string content = ReadFile(file);
    if (content.empty()) return Error{kCodeFailed, "can't read " + file};
    add(content);
  }
  add(config.hash);
  for (const StableRule& rule : proof.stable_rules) add(rule.text);
  for (const TimedRule& rule : proof.timed_rules) add(rule.text);
  add(proof.other_machine ? "other machine" : "");
  return sha.Finish();
}

std::string KeptText(const std::string& key, const std::vector<ProvedTask>& searches) {
  std::string text = std::string(kKeptHeader) + key + "\n";
  for (const ProvedTask& search : searches) text += KeptLine(search);
  return text + KeptSum(text);
}

Result<std::vector<ProvedTask>> ReadKept(std::string_view text, const std::string& key,
                                         const RuleCounts& rules) {
  if (!text.starts_with(kKeptHeader)) {
    return Error{kCodeFailed, "it has no finished searches, or those of another version"};
  }
  const std::size_t sum = text.rfind("sum ");
  if (sum == std::string_view::npos || text.substr(sum) != KeptSum(text.substr(0, sum))) {
    return Error{kCodeFailed, kKeptDamaged};
  }
  std::istringstream lines(std::string(text.substr(kKeptHeader.size(), sum - kKeptHeader.size())));
  std::string line;
  if (!std::getline(lines, line) || line != key) {
    return Error{kCodeFailed, "it is of another config, other rules or another build of Musher"};
  }
  std::vector<ProvedTask> searches;
  while (std::getline(lines, line)) {
    auto search = SearchOfLine(line, rules);
    if (!search) return Error{kCodeFailed, kKeptDamaged};
    searches.push_back(*std::move(search));
  }
  return searches;
}

Result<KeptSearches> KeptSearches::Open(const MachineConfig& config,
                                        const search::ProofOptions& proof) {
  const fs::path folder = FolderOfKeptSearches();
  if (folder.empty()) return Error{kCodeFailed, "there is no home folder to keep them in"};
  if (auto ours = CheckOnlyOurs(folder); !ours) return ours.error();
  const auto key = ProofKey(config, proof);
  if (!key) return key.error();
  KeptSearches kept;
  kept.key_ = key.value();
  kept.file_ = (folder / kept.key_.substr(0, 32)).string();
  kept.rules_ = {proof.stable_rules.size(), proof.timed_rules.size()};
  auto searches = kept.Read();
  if (searches) {
    kept.earlier_ = std::move(searches).value();
  } else {
    kept.damage_ = searches.error().message;
  }
  return kept;
}

Result<std::vector<ProvedTask>> KeptSearches::Read() const {
  const auto text = ReadOwnFile(file_);
  if (!text) return text.error();
  if (!text.value()) return std::vector<ProvedTask>();
  return ReadKept(*text.value(), key_, rules_);
}

Result<> KeptSearches::Keep(const std::vector<ProvedTask>& finished) {
  const fs::path folder = fs::path(file_).parent_path();
  if (auto ours = CheckOnlyOurs(folder); !ours) return ours;
  if (auto made = MakePrivateFolder(folder); !made) return made;
  std::vector<ProvedTask> searches = finished;
  const auto add = [&searches](const std::vector<ProvedTask>& others) {
    for (const ProvedTask& one : others) {
      if (!HasTask(searches, one.task)) searches.push_back(one);
    }
  };
  add(earlier_);
  if (const auto now = Read()) add(now.value());  // another proof may have written meanwhile
  ReplaceOptions options;
  options.mode = 0600;
  options.draft = "." + std::to_string(getpid());
  return ReplaceFile(file_, KeptText(key_, searches), options);
}

void KeptSearches::Remove(const std::vector<ProvedTask>& used) {
  const auto now = Read();
  const bool has_others = now && std::ranges::any_of(now.value(), [&](const ProvedTask& one) {
                            return !HasTask(used, one.task);
                          });
  if (has_others) return;
  std::error_code ignored;
  fs::remove(file_, ignored);
}

}  // namespace musher::cli
