#include "musher/behavior/tree/json/substitutions.hpp"

#include <array>
#include <cstdint>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <utility>

#include "musher/base/suggest.hpp"
#include "musher/behavior/tree/json/json_places.hpp"

namespace musher::tree {
namespace {

using OrderedJson = nlohmann::ordered_json;
using Path = std::vector<std::string>;

constexpr const char* kConfigs = "TestNodeConfigs";
constexpr const char* kRules = "SubstitutionRules";
constexpr std::int64_t kLongestDelayMs = 24LL * 3600 * 1000;

class Reader {
 public:
  Reader(Factory& factory, std::string_view text, const std::string& file)
      : factory_(factory), text_(text), file_(file), places_(text) {}

  std::vector<Diagnostic> Add(const OrderedJson& json) && {
    if (!json.is_object()) return Fail({}, Kind(json) + "; expected an object"), std::move(found_);
    for (const auto& [key, value] : json.items()) {
      if (key != kConfigs && key != kRules) {
        FailName({key}, "unknown field '" + key + "'" +
                            DidYouMean(key, std::vector<std::string>{kConfigs, kRules}));
      } else if (!value.is_object()) {
        Fail({key}, "'" + key + "' is " + Kind(value) + "; expected an object");
      }
    }
    if (HasError(found_)) return std::move(found_);
    if (json.contains(kConfigs)) {
      for (const auto& [name, config] : json[kConfigs].items()) AddConfig(name, config);
    }
    if (json.contains(kRules)) {
      for (const auto& [pattern, by] : json[kRules].items()) AddRule(pattern, by);
    }
    for (const auto& [name, config] : configs_) {
      if (used_.contains(name)) continue;
      Report(places_.At({kConfigs, name}).name, Severity::kWarning,
             "no rule uses the test node '" + name + "'");
    }
    if (HasError(found_)) return std::move(found_);
    for (auto& [pattern, by] : rules_) {
      const auto config = configs_.find(by);
      if (config != configs_.end()) {
        factory_.Substitute(pattern, config->second);
      } else {
        static_cast<void>(factory_.SubstituteByNode(pattern, by));  // it was found
      }
    }
    return std::move(found_);
  }

 private:
  static std::string Kind(const OrderedJson& value) {
    return std::string(value.is_null() ? "" : "of type ") + value.type_name();
  }
  void Report(std::size_t byte, Severity severity, std::string message) {
    found_.push_back(internal::JsonDiagnostic(text_, file_, byte, severity, std::move(message)));
  }
  void Fail(const Path& path, std::string message) {
    Report(places_.At(path).value, Severity::kError, std::move(message));
  }
  void FailName(const Path& path, std::string message) {
    Report(places_.At(path).name, Severity::kError, std::move(message));
  }

  void AddConfig(const std::string& name, const OrderedJson& json) {
    TestNodeConfig& config = configs_[name];
    if (!json.is_object()) {
      return Fail({kConfigs, name},
                  "test node '" + name + "' is " + Kind(json) + "; expected an object");
    }
    for (const auto& [field, value] : json.items()) {
      const Path path = {kConfigs, name, field};
      if (field == "return_status") {
        ReadStatus(path, value, config.result);
      } else if (field == "async_delay") {
        ReadDelay(path, value, config.delay);
      } else if (field == "success_script") {
        ReadText(path, value, config.success_script);
      } else if (field == "failure_script") {
        ReadText(path, value, config.failure_script);
      } else if (field == "post_script") {
        ReadText(path, value, config.post_script);
      } else {
        constexpr std::array<std::string_view, 5> kFields = {
            "return_status", "async_delay", "success_script", "failure_script", "post_script"};
        FailName(path, "unknown field '" + field + "'" + DidYouMean(field, kFields));
      }
    }
  }

  void ReadStatus(const Path& path, const OrderedJson& value, Status& status) {
    constexpr std::array kStatus = {Status::kSuccess, Status::kFailure, Status::kSkipped};
    for (const Status each : kStatus) {
      if (value.is_string() && value.get<std::string>() == Name(each)) {
        status = each;
        return;
      }
    }
    Fail(path, "'return_status' is " +
                   (value.is_string() ? "'" + value.get<std::string>() + "'" : Kind(value)) +
                   "; expected SUCCESS, FAILURE or SKIPPED");
  }
  void ReadDelay(const Path& path, const OrderedJson& value, Duration& delay) {
    if (value.is_number_integer() && value.get<double>() >= 0 &&
        value.get<double>() <= static_cast<double>(kLongestDelayMs)) {
      delay = Milliseconds(value.get<std::int64_t>());
      return;
    }
    Fail(path, "'async_delay' is " + (value.is_number() ? value.dump() : Kind(value)) +
                   "; expected a whole number of ms from 0 to " + std::to_string(kLongestDelayMs));
  }
  void ReadText(const Path& path, const OrderedJson& value, std::string& text) {
    if (value.is_string()) {
      text = value.get<std::string>();
      return;
    }
    Fail(path, "'" + path.back() + "' is " + Kind(value) + "; expected a script as a text");
  }

  void AddRule(const std::string& pattern, const OrderedJson& by) {
    const Path path = {kRules, pattern};
    if (pattern.empty()) return FailName(path, "a rule has no name or path");
    if (!by.is_string()) {
      return Fail(path, "rule '" + pattern + "' is " + Kind(by) +
                            "; expected the name of a test node or of a node");
    }
    const auto name = by.get<std::string>();
    used_.insert(name);
    rules_.emplace_back(pattern, name);
    if (configs_.contains(name) || factory_.Find(name) != nullptr) return;
    std::vector<std::string> known = factory_.Names();
    for (const auto& [config, unused] : configs_) known.push_back(config);
    Fail(path, "there is neither a test node nor a node '" + name + "'" + DidYouMean(name, known));
  }

  Factory& factory_;
  const std::string_view text_;
  const std::string& file_;
  const internal::JsonPlaces places_;
  std::map<std::string, TestNodeConfig> configs_;
  std::vector<std::pair<std::string, std::string>> rules_;
  std::set<std::string> used_;
  std::vector<Diagnostic> found_;
};

}  // namespace

std::vector<Diagnostic> AddSubstitutions(Factory& factory, std::string_view json,
                                         const std::string& file) {
  if (internal::IsTooLargeJson(json)) {
    return {
        {file, 0, 0, Severity::kError, "the JSON is larger than 1 MiB, or nested deeper than 100"}};
  }
  OrderedJson parsed;
  try {
    parsed = OrderedJson::parse(json);
  } catch (const OrderedJson::parse_error& error) {
    return {internal::JsonDiagnostic(json, file, error.byte == 0 ? 0 : error.byte - 1,
                                     Severity::kError, "it is no JSON")};
  }
  return Reader(factory, json, file).Add(parsed);
}

std::vector<Diagnostic> AddSubstitutionsOfFile(Factory& factory, const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  if (!file || !(text << file.rdbuf())) {
    return {{path, 0, 0, Severity::kError, "the file can not be read"}};
  }
  return AddSubstitutions(factory, text.str(), path);
}

}  // namespace musher::tree
