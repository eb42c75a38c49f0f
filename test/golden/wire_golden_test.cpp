// Processes of different versions of Musher understand each other: what a version has sent is read
// by all that come after it, and what they send begins as that version knows it. wire/<version>.txt
// has the bytes of every message of that version. A new version adds its file with
// MUSHER_UPDATE_GOLDEN=1 in the environment; the files of earlier versions are never written again.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include "musher/base/version.hpp"
#include "musher/messages/interfaces.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/test/contract/fill.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::msg::wire_golden_test {

namespace fs = std::filesystem;

// Of one type: the bytes of a sample, and whether bytes of another version can be read.
struct Coding {
  std::string bytes;  // as hexadecimal digits
  bool (*reads)(const std::string& digits) = nullptr;
};

std::string Digits(const Bytes& bytes) {
  std::string digits;
  for (const std::byte byte : bytes) {
    digits += fmt::format("{:02x}", std::to_integer<unsigned>(byte));
  }
  return digits;
}

Bytes FromDigits(const std::string& digits) {
  Bytes bytes;
  bytes.reserve(digits.size() / 2);
  for (std::size_t i = 0; i + 1 < digits.size(); i += 2) {
    bytes.push_back(static_cast<std::byte>(std::stoul(digits.substr(i, 2), nullptr, 16)));
  }
  return bytes;
}

// The messages and services of the package musher_msgs.
struct Ours {
  template <class M>
  void Message() {
    if (M::kTypeName.starts_with(kPackage)) Add<M>(std::string(M::kTypeName));
  }
  template <class S>
  void Service() {
    if (!S::kTypeName.starts_with(kPackage)) return;
    Add<typename S::Request>(std::string(S::kTypeName) + "Request_");
    Add<typename S::Response>(std::string(S::kTypeName) + "Response_");
  }
  template <class A>
  void Action() {}

  template <class T>
  void Add(const std::string& name) {
    codings[name] = {Digits(Encode(Filled<T>())), [](const std::string& digits) {
                       const auto read = Decode<T>(FromDigits(digits));
                       // What was read, and sent again, is the same as far as it went.
                       return read && Digits(Encode(*read)).starts_with(digits);
                     }};
  }

  static constexpr std::string_view kPackage = "musher_msgs::";
  std::map<std::string, Coding> codings;
};

fs::path Folder() {
  return fs::path(SourceDir()) / "test" / "golden" / "wire";
}

// The digits of each message in a file.
std::map<std::string, std::string> Recorded(const fs::path& path) {
  std::map<std::string, std::string> recorded;
  std::ifstream file(path);
  for (std::string name, digits; file >> name >> digits;) recorded[name] = digits;
  return recorded;
}

TEST(WireCompatibility, EveryMessageOfEveryVersionIsReadAndOnlyGrowsAtItsEnd) {
  Ours ours;
  VisitInterfaces(ours);
  const auto& now = ours.codings;
  const fs::path version = Folder() / (std::string(Version()) + ".txt");
  if (std::getenv("MUSHER_UPDATE_GOLDEN") != nullptr && !fs::exists(version)) {
    std::ofstream file(version);
    for (const auto& [name, coding] : now) file << name << " " << coding.bytes << "\n";
  }
  int versions = 0;
  for (const auto& entry : fs::directory_iterator(Folder())) {
    SCOPED_TRACE("as in " + entry.path().filename().string());
    for (const auto& [name, digits] : Recorded(entry.path())) {
      const auto coding = now.find(name);
      ASSERT_NE(coding, now.end()) << name << " was removed";
      EXPECT_TRUE(coding->second.bytes.starts_with(digits)) << name << " begins differently";
      EXPECT_TRUE(coding->second.reads(digits)) << name << " is not read";
    }
    ++versions;
  }
  EXPECT_GE(versions, 2);
}

// A field that was appended since the last version is in no file of a version: its place and its
// type could change without a word.
TEST(WireCompatibility, EveryFieldIsRecordedAlsoBetweenTwoVersions) {
  Ours ours;
  VisitInterfaces(ours);
  const fs::path present = Folder() / "present.txt";
  if (std::getenv("MUSHER_UPDATE_GOLDEN") != nullptr) {
    std::ofstream file(present);
    for (const auto& [name, coding] : ours.codings) file << name << " " << coding.bytes << "\n";
  }
  const auto recorded = Recorded(present);
  EXPECT_EQ(recorded.size(), ours.codings.size());
  for (const auto& [name, coding] : ours.codings) {
    const auto found = recorded.find(name);
    ASSERT_NE(found, recorded.end()) << name << " is new: MUSHER_UPDATE_GOLDEN=1 records it";
    EXPECT_EQ(found->second, coding.bytes)
        << name << ": if only fields were appended, MUSHER_UPDATE_GOLDEN=1 records them";
  }
}

TEST(WireCompatibility, AControllerThatDoesNotSendWhetherItAwaitsARequestAwaitsNone) {
  const std::string name(ControllerHeartbeat::kTypeName);
  const std::string old = Recorded(Folder() / "0.2.0.txt")[name];
  const std::string present = Recorded(Folder() / "present.txt")[name];
  ASSERT_TRUE(present.starts_with(old)) << present;
  ASSERT_GT(present.size(), old.size());
  const auto from_old = Decode<ControllerHeartbeat>(FromDigits(old));
  ASSERT_TRUE(from_old);
  EXPECT_NE(from_old->participant, 0U) << "the field before it";
  EXPECT_FALSE(from_old->awaits_request);
  for (const char* last : {"00", "01"}) {
    const auto read = Decode<ControllerHeartbeat>(FromDigits(old + last));
    ASSERT_TRUE(read);
    EXPECT_EQ(read->awaits_request, last == std::string("01"));
  }
}

}  // namespace musher::msg::wire_golden_test
