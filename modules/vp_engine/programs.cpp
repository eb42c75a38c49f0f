#include "musher/modules/vp_engine/programs.hpp"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "musher/base/files.hpp"
#include "musher/base/suggest.hpp"
#include "musher/base/toml/file.hpp"

namespace musher::vp_engine {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kLongestName = 64;

Error Refused(std::string why) {
  return {kCodeParametersInvalid, std::move(why)};
}

Error InvalidName(const std::string& name) {
  return Refused("invalid name '" + name.substr(0, kLongestName) +
                 "'; expected letters, digits, '_' and '-', at most 64, not beginning with '-'");
}

}  // namespace

std::string_view Name(ProgramState state) {
  switch (state) {
    case ProgramState::kReady:
      return "ready";
    case ProgramState::kRunning:
      return "running";
    case ProgramState::kSucceeded:
      return "succeeded";
    case ProgramState::kFailed:
      return "failed";
    case ProgramState::kStopped:
      return "stopped";
    case ProgramState::kInvalid:
      return "invalid";
  }
  return "";
}

bool IsProgramName(std::string_view name) {
  if (name.empty() || name.size() > kLongestName || name.front() == '-') return false;
  return std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-';
  });
}

Result<> Programs::Open() {
  adding_.clear();  // of topics that were closed
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error)
    return Error{kCodeFailed, "cannot make the folder " + folder_ + ": " + error.message()};
  return Ok();
}

std::map<std::string, std::string> Programs::Paths() const {
  std::map<std::string, std::string> paths;
  for (const std::string& folder : {folder_, examples_}) {
    if (folder.empty()) continue;
    for (const fs::path& path : EntriesOf(folder)) {
      const std::string name = path.stem().string();
      if (path.extension() == ".xml" && IsProgramName(name)) paths.emplace(name, path.string());
    }
  }
  return paths;
}

const std::string& Programs::Errors(const std::string& name, const std::string& text) {
  const auto found = checked_.find(name);
  if (found != checked_.end() && found->second.text == text) return found->second.errors;
  return checked_.insert_or_assign(name, Checked{text, check_(name, text)}).first->second.errors;
}

std::vector<Program> Programs::List() {
  std::vector<Program> list;
  for (const auto& [name, path] : Paths()) {
    const auto text = config_toml::ReadTextFile(path, kLargestProgram);
    std::string errors;
    if (!text) errors = text.error().message;
    if (text && !adding_.contains(name)) errors = Errors(name, text.value());
    const auto known = known_.find(name);
    if (name == running_) {
      list.push_back({name, ProgramState::kRunning, ""});
    } else if (!errors.empty()) {
      list.push_back({name, ProgramState::kInvalid, std::move(errors)});
    } else if (known != known_.end()) {
      list.push_back({name, known->second.state, known->second.message});
    } else {
      list.push_back({name, ProgramState::kReady, ""});
    }
  }
  return list;
}

Error Programs::Unknown(const std::string& name) const {
  if (!IsProgramName(name)) return InvalidName(name);
  std::vector<std::string> names;
  for (const auto& [each, path] : Paths()) names.push_back(each);
  return Refused(NoSuch("program", name, names));
}

Result<std::string> Programs::Text(const std::string& name) const {
  const auto paths = Paths();
  const auto found = paths.find(name);
  if (found == paths.end()) return Unknown(name);
  return config_toml::ReadTextFile(found->second, kLargestProgram);
}

Result<> Programs::WhileAdding(const std::string& name) const {
  if (!adding_.contains(name)) return Ok();
  return Refused("program '" + name + "' is being added; wait for its reply");
}

Result<std::string> Programs::BeginAdd(const std::string& name, const std::string& text) {
  if (!IsProgramName(name)) return InvalidName(name);
  if (name == running_) return Refused("program '" + name + "' is running; stop it first");
  if (text.size() > kLargestProgram) return Refused("the program is larger than 1 MiB");
  if (Result<> adding = WhileAdding(name); !adding) return adding.error();
  const auto paths = Paths();
  if (paths.size() + adding_.size() >= kMostPrograms && !paths.contains(name)) {
    return Refused("there are already " + std::to_string(kMostPrograms) + " programs");
  }
  adding_.insert(name);
  return PathOf(name);
}

Result<> Programs::EndAdd(const std::string& name, const std::string& text,
                          const std::string& errors, const Result<>& stored) {
  adding_.erase(name);
  if (!errors.empty()) return Refused(errors);
  if (!stored) return stored;
  checked_.insert_or_assign(name, Checked{text, ""});
  known_.erase(name);
  return Ok();
}

Result<> Programs::Remove(const std::string& name) {
  const auto paths = Paths();
  const auto found = paths.find(name);
  if (found == paths.end()) return Unknown(name);
  if (name == running_) return Refused("program '" + name + "' is running; stop it first");
  if (Result<> adding = WhileAdding(name); !adding) return adding;
  if (found->second != fs::path(folder_) / (name + ".xml")) {
    return Refused("program '" + name + "' is an example, which is not deleted");
  }
  std::error_code error;
  fs::remove(found->second, error);
  if (error) return Error{kCodeFailed, "cannot delete " + found->second + ": " + error.message()};
  known_.erase(name);
  checked_.erase(name);
  return Ok();
}

Result<std::string> Programs::Runnable(const std::string& name) {
  if (Result<> adding = WhileAdding(name); !adding) return adding.error();
  Result<std::string> text = Text(name);
  if (!text) return text;
  if (const std::string& errors = Errors(name, text.value()); !errors.empty()) {
    return Refused(errors);
  }
  return text;
}

void Programs::Started(const std::string& name) {
  running_ = name;
}

void Programs::Ended(ProgramState state, const std::string& message) {
  if (running_.empty()) return;
  known_.insert_or_assign(std::exchange(running_, ""), Known{state, message});
}

}  // namespace musher::vp_engine
