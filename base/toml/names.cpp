#include "musher/base/toml/names.hpp"

#include <algorithm>
#include <cstdlib>
#include <system_error>

namespace musher::config_toml {
namespace {

constexpr std::size_t kLongestName = 64;
constexpr std::size_t kLongestNamespace = 200;

bool IsDigit(char c) {
  return c >= '0' && c <= '9';
}

bool IsNameCharacter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || IsDigit(c) || c == '_';
}

// An environment variable that holds an absolute path; others are ignored, as XDG requires.
std::filesystem::path AbsoluteFromEnvironment(const char* variable) {
  const char* value = std::getenv(variable);  // NOLINT(concurrency-mt-unsafe)
  return value != nullptr && value[0] == '/' ? value : "";
}

}  // namespace

bool IsName(std::string_view text) {
  return !text.empty() && text.size() <= kLongestName && !IsDigit(text.front()) &&
         std::all_of(text.begin(), text.end(), IsNameCharacter);
}

bool IsNamespace(std::string_view text) {
  if (text.size() > kLongestNamespace) return false;
  if (text.empty()) return true;
  while (true) {
    const std::size_t slash = text.find('/');
    if (!IsName(text.substr(0, slash))) return false;
    if (slash == std::string_view::npos) return true;
    text.remove_prefix(slash + 1);
  }
}

bool IsTopic(std::string_view text) {
  return IsRelativeTopic(text.substr(text.starts_with('/') ? 1 : 0));
}

bool IsRelativeTopic(std::string_view text) {
  return !text.empty() && IsNamespace(text);
}

std::filesystem::path FolderOf(const std::string& file) {
  std::error_code ignored;  // without a working directory the path stays as it is
  const std::filesystem::path absolute = std::filesystem::absolute(file, ignored);
  return (absolute.empty() ? std::filesystem::path(file) : absolute).parent_path();
}

std::string NameOf(const std::string& file) {
  std::string name = std::filesystem::path(file).stem().string();
  if (name.empty()) return "machine";
  if (IsDigit(name.front())) name.insert(0, "_");
  name.resize(std::min(name.size(), kLongestName));
  std::replace_if(
      name.begin(), name.end(), [](char c) { return !IsNameCharacter(c); }, '_');
  return name;
}

std::string Absolute(const std::filesystem::path& folder, const std::string& path) {
  std::string absolute = (folder / path).lexically_normal().string();
  if (absolute.size() > 1 && absolute.ends_with('/')) absolute.pop_back();
  return absolute;
}

std::string DefaultStateDir(const std::string& name, const std::string& name_space) {
  std::filesystem::path state = AbsoluteFromEnvironment("XDG_STATE_HOME");
  if (state.empty()) {
    const std::filesystem::path home = AbsoluteFromEnvironment("HOME");
    state = home.empty() ? "/var/lib" : home / ".local" / "state";
  }
  std::string folder = name;
  if (!name_space.empty()) {
    folder += "@" + name_space;
    std::replace(folder.begin(), folder.end(), '/', '.');
  }
  const char* variable = std::getenv("ROS_DOMAIN_ID");  // NOLINT(concurrency-mt-unsafe)
  const std::string domain = variable == nullptr ? "" : variable;
  const bool number = !domain.empty() &&
                      std::all_of(domain.begin(), domain.end(), [](char c) { return IsDigit(c); });
  if (number && domain != "0") folder += ".domain" + domain;
  return (state / "musher" / folder).string();
}

}  // namespace musher::config_toml
