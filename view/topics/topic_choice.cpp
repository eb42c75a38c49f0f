#include "musher/view/topics/topic_choice.hpp"

#include <algorithm>
#include <cctype>
#include <optional>

namespace musher::view {
namespace {

bool IsOfPattern(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '/' || c == '*' ||
         c == '?';
}

Result<std::vector<std::string>> Resolve(const std::vector<std::string>& patterns,
                                         const std::string& name_space) {
  std::vector<std::string> resolved;
  for (const std::string& pattern : patterns) {
    if (pattern.empty() || !std::all_of(pattern.begin(), pattern.end(), IsOfPattern)) {
      return Error{kCodeParametersInvalid,
                   "invalid topic pattern '" + pattern +
                       "'; expected letters, digits, '_', '/', '*' and '?', as in /camera/*"};
    }
    const std::string root = name_space.empty() ? "/" : "/" + name_space + "/";
    resolved.push_back(pattern.starts_with('/') || pattern.starts_with('*') ? pattern
                                                                            : root + pattern);
  }
  return resolved;
}

}  // namespace

bool Matches(std::string_view pattern, std::string_view topic) {
  std::size_t p = 0;
  std::size_t t = 0;
  std::optional<std::size_t> star;  // the last one, which takes the characters up to `resume`
  std::size_t resume = 0;
  while (t < topic.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      resume = t;
    } else if (p < pattern.size() && (pattern[p] == '?' || pattern[p] == topic[t])) {
      ++p;
      ++t;
    } else if (star) {
      p = *star + 1;
      t = ++resume;
    } else {
      return false;
    }
  }
  while (p < pattern.size() && pattern[p] == '*') ++p;
  return p == pattern.size();
}

std::string RosTopic(std::string_view dds_topic) {
  return dds_topic.starts_with("rt/") ? std::string(dds_topic.substr(2)) : "";
}

Result<TopicChoice> TopicChoice::Of(const std::vector<std::string>& wanted,
                                    const std::vector<std::string>& excluded,
                                    const std::string& name_space) {
  auto in = Resolve(wanted, name_space);
  if (!in) return in.error();
  auto out = Resolve(excluded, name_space);
  if (!out) return out.error();
  TopicChoice choice;
  choice.wanted_ = std::move(in).value();
  choice.excluded_ = std::move(out).value();
  return choice;
}

bool TopicChoice::Takes(const std::string& topic) {
  if (topic.empty()) return false;
  bool taken = wanted_.empty();
  for (const std::string& pattern : wanted_) {
    if (!Matches(pattern, topic)) continue;
    taken = true;
    matched_.insert(pattern);
  }
  for (const std::string& pattern : excluded_) {
    if (!Matches(pattern, topic)) continue;
    taken = false;
    matched_.insert(pattern);
  }
  return taken;
}

std::vector<std::string> TopicChoice::Unmatched() const {
  std::vector<std::string> unmatched;
  for (const auto* patterns : {&wanted_, &excluded_}) {
    for (const std::string& pattern : *patterns) {
      if (!matched_.contains(pattern)) unmatched.push_back(pattern);
    }
  }
  return unmatched;
}

}  // namespace musher::view
