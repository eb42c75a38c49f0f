// The permissions that `musher keys` writes for each role, byte for byte: permissions.expected.
// Credentials that were issued earlier stay on robots, so that a change is to be noticed. With
// MUSHER_UPDATE_GOLDEN=1 in the environment the test writes the file instead, to be read before it
// is committed.

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>

#include "musher/cyberdog/interfaces.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/wire/security/permissions.hpp"

namespace musher::permissions_golden_test {

using transport::keys::Grant;
using transport::keys::PermissionsXml;
using transport::keys::Role;
using transport::keys::WallTime;

TEST(Permissions, OfEachRoleAreThoseOfTheGoldenFile) {
  constexpr std::chrono::days kFrom(20'000);
  std::string text;
  for (const Role role : transport::keys::kRoles) {
    const std::string name(RoleName(role));
    const Grant grant{name, "CN=" + name, role, WallTime(kFrom), WallTime(kFrom * 2)};
    text += PermissionsXml(grant, cyberdog::Interfaces());
  }
  const std::string file = SourceDir() + "/test/golden/permissions.expected";
  if (std::getenv("MUSHER_UPDATE_GOLDEN") != nullptr) {
    std::ofstream(file, std::ios::binary) << text;
  }
  std::ifstream in(file, std::ios::binary);
  const std::string expected{std::istreambuf_iterator<char>(in), {}};
  EXPECT_EQ(text, expected);
}

}  // namespace musher::permissions_golden_test
