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
#include "musher/messages/musher_msgs/actuator_command.hpp"
#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/messages/musher_msgs/behavior.hpp"
#include "musher/messages/musher_msgs/body.hpp"
#include "musher/messages/musher_msgs/capabilities.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/messages/musher_msgs/machine_status.hpp"
#include "musher/messages/musher_msgs/policy_request.hpp"
#include "musher/test/contract/fill.hpp"

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

using Codings = std::map<std::string, Coding>;

template <class T>
void AddMessage(Codings& codings, const std::string& name) {
  codings[name] = {Digits(Encode(Filled<T>())), [](const std::string& digits) {
                     const auto read = Decode<T>(FromDigits(digits));
                     // What was read, and sent again, is the same as far as it went.
                     return read && Digits(Encode(*read)).starts_with(digits);
                   }};
}
template <class T>
void AddTopic(Codings& codings) {
  AddMessage<T>(codings, std::string(T::kTypeName));
}
template <class S>
void AddService(Codings& codings) {
  AddMessage<typename S::Request>(codings, std::string(S::kTypeName) + "Request_");
  AddMessage<typename S::Response>(codings, std::string(S::kTypeName) + "Response_");
}

Codings AllCodings() {
  Codings codings;
  AddTopic<ActuatorBeat>(codings);
  AddTopic<ActuatorStatus>(codings);
  AddTopic<BehaviorChange>(codings);
  AddTopic<BodyState>(codings);
  AddTopic<Capabilities>(codings);
  AddTopic<ControllerBeat>(codings);
  AddTopic<EmergencyStop>(codings);
  AddTopic<LedState>(codings);
  AddTopic<MachineInfo>(codings);
  AddTopic<MachineStatus>(codings);
  AddService<ActuatorCommand>(codings);
  AddService<GetBehavior>(codings);
  AddService<GetCapabilities>(codings);
  AddService<GetHistory>(codings);
  AddService<GetPlan>(codings);
  AddService<GetStatus>(codings);
  AddService<GetSwitch>(codings);
  AddService<ReleaseEmergencyStop>(codings);
  AddService<RequestPolicy>(codings);
  AddService<RestartActuator>(codings);
  AddService<SendCommand>(codings);
  AddService<SetState>(codings);
  return codings;
}

TEST(WireCompatibility, EveryMessageOfEveryVersionIsReadAndOnlyGrowsAtItsEnd) {
  const fs::path folder = fs::path(MUSHER_SOURCE_DIR) / "test" / "golden" / "wire";
  const Codings now = AllCodings();
  if (std::getenv("MUSHER_UPDATE_GOLDEN") != nullptr) {
    std::ofstream file(folder / (std::string(Version()) + ".txt"));
    for (const auto& [name, coding] : now) file << name << " " << coding.bytes << "\n";
  }
  int versions = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    SCOPED_TRACE("as version " + entry.path().stem().string() + " sent it");
    std::ifstream file(entry.path());
    for (std::string name, digits; file >> name >> digits;) {
      const auto coding = now.find(name);
      ASSERT_NE(coding, now.end()) << name << " is gone";
      EXPECT_TRUE(coding->second.bytes.starts_with(digits)) << name << " begins differently";
      EXPECT_TRUE(coding->second.reads(digits)) << name << " is not read";
    }
    ++versions;
  }
  EXPECT_GE(versions, 1);
}

}  // namespace musher::msg::wire_golden_test
