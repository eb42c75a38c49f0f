#include "musher/cli/config/key_reference.hpp"

#include <algorithm>
#include <sstream>

#include "musher/base/suggest.hpp"

namespace musher::cli {
namespace {

// "[actuator.<name>]" gives {"actuator", "<name>"}; also of "actuator.audio.restart".
std::vector<std::string> PartsOf(std::string_view text) {
  std::string plain(text);
  for (char& c : plain) {
    if (c == '[' || c == ']' || c == '.' || c == '`') c = ' ';
  }
  std::istringstream words(plain);
  std::vector<std::string> parts;
  for (std::string part; words >> part;) parts.push_back(part);
  return parts;
}

bool Fits(const std::string& part, const std::string& typed) {
  return part == typed || part == "<name>";
}

// `typed` is the end of the full name, or its table with all keys below it.
bool IsMeant(const KeyReference& key, const std::vector<std::string>& typed) {
  std::vector<std::string> full = PartsOf(key.table);
  const std::size_t table = full.size();
  if (!key.key.empty()) full.push_back(key.key);
  if (typed.size() == table && std::equal(typed.begin(), typed.end(), full.begin())) return true;
  return typed.size() <= full.size() && full.back() == typed.back() &&
         std::equal(typed.rbegin(), typed.rend(), full.rbegin(),
                    [](const auto& one, const auto& part) { return Fits(part, one); });
}

}  // namespace

Result<std::vector<KeyReference>> FindKeys(std::string_view words) {
  const std::vector<std::string> typed = PartsOf(words);
  std::vector<KeyReference> found;
  std::vector<std::string> names;
  for (const KeyReference& key : AllKeys()) {
    if (!typed.empty() && IsMeant(key, typed)) found.push_back(key);
    if (!key.key.empty()) names.push_back(key.key);
  }
  if (!found.empty()) return found;
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return Error{kCodeParametersInvalid, "a state config has no key '" + std::string(words) + "'" +
                                           (typed.empty() ? "" : DidYouMean(typed.back(), names))};
}

}  // namespace musher::cli
