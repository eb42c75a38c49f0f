#include "musher/base/code.hpp"

#include <array>
#include <map>
#include <mutex>
#include <regex>

namespace musher {
namespace {

constexpr std::array<const char*, 14> kKeyNames = {
    "ok",          "Failed",          "Uninitialized",     "StateInvalid",
    "StatusError", "NetError",        "PermissionDenied",  "Timeout",
    "UnSupport",   "SelfCheckFailed", "ParametersInvalid", "TargetBusy",
    "DeviceError", "ProtectedError"};

constexpr ModuleName kOwnNames[] = {{ModuleCode::kRobot, "Robot"}, {ModuleCode::kOta, "OTA"}};

class ModuleNames {
 public:
  bool Add(std::span<const ModuleName> names) {
    const std::lock_guard lock(mutex_);
    bool all = true;
    for (const auto& [module, name] : names) {
      all = names_.try_emplace(module, name).first->second == name && all;
    }
    return all;
  }

  // Empty: none.
  std::string_view Of(ModuleCode module) const {
    const std::lock_guard lock(mutex_);
    const auto found = names_.find(module);
    return found == names_.end() ? std::string_view() : found->second;
  }

 private:
  mutable std::mutex mutex_;
  std::map<ModuleCode, std::string_view> names_;
};

// Made when it is first used, which may be before main(), and never destroyed: threads may still
// print codes when the process exits.
ModuleNames& NamesOfThisProcess() {
  static auto* const names = [] {
    auto* made = new ModuleNames;
    made->Add(kOwnNames);
    return made;
  }();
  return *names;
}

bool IsDigit(char c) {
  return c >= '0' && c <= '9';
}

// Whether the sentence has the code already. Of a code without a name only as a number of its own,
// and not where it is so short that it may count something.
bool Says(const std::string& message, const std::string& code) {
  constexpr std::size_t kShortest = 4;
  const std::size_t at = message.find(code);
  if (at == std::string::npos) return false;
  if (code.ends_with(')')) return true;
  const std::size_t end = at + code.size();
  const bool alone =
      (at == 0 || !IsDigit(message[at - 1])) && (end == message.size() || !IsDigit(message[end]));
  return code.size() >= kShortest && alone;
}

}  // namespace

bool NameModules(std::span<const ModuleName> names) {
  return NamesOfThisProcess().Add(names);
}

std::string CodeText(std::int32_t code) {
  std::string number = std::to_string(code);
  if (code < 0) return number;
  const std::int32_t key = code % 100;
  const bool named_key = key < static_cast<std::int32_t>(kKeyNames.size());
  if (code < 100) return named_key ? number + " (" + kKeyNames[key] + ")" : number;
  const std::string_view module = NamesOfThisProcess().Of(static_cast<ModuleCode>(code - key));
  if (module.empty()) return number;
  number.append(" (").append(module);
  if (named_key && key > 0) number.append(": ").append(kKeyNames[key]);
  return number + ")";
}

std::string WithoutModuleNames(const std::string& text) {
  static const std::regex named(R"((\d{3,4}) \([^():]+(: \w+)?\))");
  static const std::regex in_brackets(R"(\((\d{3,4}) [A-Z]\w*(: \w+)?\))");
  return std::regex_replace(std::regex_replace(text, named, "$1"), in_brackets, "($1)");
}

std::string WithCode(const std::string& message, std::int32_t code) {
  const std::string text = CodeText(code);
  std::string in_brackets = "(" + text + ")";  // without brackets of its own
  if (text.ends_with(')')) in_brackets = "(" + text;
  if (const std::size_t inner = in_brackets.find(" ("); inner != std::string::npos) {
    in_brackets.erase(inner + 1, 1);
  }
  const bool says = Says(message, text) || message.find(in_brackets) != std::string::npos;
  if (code == kCodeOk || says) return message;
  return message + (message.empty() ? "" : " ") + in_brackets;
}

}  // namespace musher
