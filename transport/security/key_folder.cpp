#include "musher/transport/security/key_folder.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "musher/base/files.hpp"

namespace musher::transport::keys {
namespace {

constexpr std::size_t kLongestName = 64;

}  // namespace

std::vector<std::string> KeyFolder::Identities() const {
  std::vector<std::string> names;
  for (const std::filesystem::path& file : EntriesOf(path_)) {
    const bool authority = file == IdentityCa() || file == PermissionsCa();
    if (file.extension() == ".cert" && !authority) names.push_back(file.stem());
  }
  std::sort(names.begin(), names.end());
  return names;
}

bool IsIdentityName(const std::string& name) {
  const auto fits = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; };
  return !name.empty() && name.size() <= kLongestName && name != "identity_ca" &&
         name != "permissions_ca" && std::isdigit(static_cast<unsigned char>(name.front())) == 0 &&
         std::all_of(name.begin(), name.end(), fits);
}

}  // namespace musher::transport::keys
