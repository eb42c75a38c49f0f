// For schema_test.js: writes a recording of a few messages to the file that is its argument.

#include <cstdio>

#include "musher/messages/musher_msgs/machine_status.hpp"
#include "musher/messages/sensor_msgs/joint_state.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/view/record/recording_file.hpp"

namespace musher::view {
namespace {

Result<> Record(const std::string& path) {
  auto file = RecordingFile::Open(path, mcap::Compression::kNone);
  if (!file) return file.error();
  std::size_t channel = 0;
  std::int64_t log_ns = 1'772'366'405'000'000'001;
  Result<> written;
  const auto write = [&](const std::string& topic, const auto& message) {
    using Type = std::decay_t<decltype(message)>;
    const RecordedChannel declared{topic, std::string(Type::kTypeName), "", false};
    const msg::Bytes bytes = msg::Encode(message);
    if (written) written = file.value()->Write(declared, channel, log_ns, log_ns, bytes);
    ++channel;
    ++log_ns;
  };
  write("/chat", msg::String{"hello"});
  msg::MachineStatus status;
  status.state = "Active";
  status.epoch = 7;
  status.actuators.resize(2);
  status.actuators[1].name = "audio";
  status.held_by_stop = {"audio"};
  write("/musher/machine_status", status);
  msg::JointState joints;
  joints.header.stamp = {1'772'366'405, 5};
  joints.name = {"knee", "hip"};
  joints.position = {0.5, -0.25};
  write("/joint_states", joints);
  return written ? file.value()->Close() : written;
}

}  // namespace
}  // namespace musher::view

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const auto recorded = musher::view::Record(argv[1]);
  if (!recorded) std::fprintf(stderr, "%s\n", recorded.error().message.c_str());
  return recorded ? 0 : 1;
}
