#include "musher/behavior/tree/json/json_places.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

namespace musher::tree::internal {
namespace {

constexpr std::size_t kLongestJson = 1U << 20U;
constexpr int kDeepestJson = 100;

bool IsTooDeep(std::string_view json) {
  int depth = 0;
  bool in_text = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    if (in_text && json[i] == '\\') {
      ++i;
    } else if (json[i] == '"') {
      in_text = !in_text;
    } else if (!in_text && (json[i] == '{' || json[i] == '[')) {
      if (++depth > kDeepestJson) return true;
    } else if (!in_text && (json[i] == '}' || json[i] == ']')) {
      --depth;
    }
  }
  return false;
}

}  // namespace

bool IsTooLargeJson(std::string_view json) {
  return json.size() > kLongestJson || IsTooDeep(json);
}

JsonPlaces::JsonPlaces(std::string_view json) : json_(json) {
  std::vector<std::string> path;
  Value(path);
}

JsonPlaces::Field JsonPlaces::At(const std::vector<std::string>& path) const {
  const auto found = fields_.find(path);
  return found == fields_.end() ? Field{} : found->second;
}

void JsonPlaces::Space() {
  while (at_ < json_.size() &&
         std::string_view(" \t\r\n").find(json_[at_]) != std::string_view::npos)
    ++at_;
}

std::string JsonPlaces::Text() {
  const std::size_t begin = at_++;
  while (at_ < json_.size() && json_[at_] != '"') at_ += json_[at_] == '\\' ? 2 : 1;
  at_ = std::min(at_ + 1, json_.size());
  return std::string(json_.substr(begin, at_ - begin));
}

void JsonPlaces::Value(std::vector<std::string>& path) {
  Space();
  if (at_ >= json_.size()) return;
  if (json_[at_] == '{') return Object(path);
  if (json_[at_] == '[') return Array(path);
  if (json_[at_] == '"') {
    Text();
    return;
  }
  at_ = std::min(json_.find_first_of(",]} \t\r\n", at_), json_.size());
}

void JsonPlaces::Object(std::vector<std::string>& path) {
  for (++at_, Space(); at_ < json_.size() && json_[at_] == '"'; Space()) {
    Field field{.name = at_};
    path.push_back(nlohmann::json::parse(Text()).get<std::string>());
    Space();
    ++at_;  // the colon
    Space();
    field.value = at_;
    if (arrays_ == 0) fields_.insert_or_assign(path, field);
    Value(path);
    path.pop_back();
    Space();
    if (at_ >= json_.size() || json_[at_] != ',') break;
    ++at_;
  }
  ++at_;
}

void JsonPlaces::Array(std::vector<std::string>& path) {
  ++arrays_;
  for (++at_, Space(); at_ < json_.size() && json_[at_] != ']'; Space()) {
    Value(path);
    Space();
    if (at_ >= json_.size() || json_[at_] != ',') break;
    ++at_;
  }
  ++at_;
  --arrays_;
}

Diagnostic JsonDiagnostic(std::string_view json, const std::string& file, std::size_t byte,
                          Severity severity, std::string message) {
  const std::string_view before = json.substr(0, std::min(byte, json.size()));
  const auto line = std::ranges::count(before, '\n') + 1;
  const std::size_t begin = before.rfind('\n') + 1;  // npos + 1 is 0
  return {file, static_cast<int>(line), static_cast<int>(before.size() - begin + 1), severity,
          std::move(message)};
}

}  // namespace musher::tree::internal
