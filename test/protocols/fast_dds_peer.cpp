// A process on Fast DDS, the default DDS of most ROS 2 installations, without any of our code. It
// publishes one sample on one topic, prints what it receives on another one, and runs until it is
// killed.
//
//   fast_dds_peer <domain> <type> <published topic> <file of the sample> <subscribed topic>
//
// The names are those on DDS: "std_msgs::msg::dds_::String_", "rt/chat". The topics are reliable
// and latched. It prints "ready" once it has joined, and of each received sample, with its
// encapsulation header, "received <bytes> <sum of the bytes>".

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>

#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <iostream>
#include <iterator>
#include <string>
#include <vector>

namespace fast = eprosima::fastdds::dds;
using eprosima::fastrtps::rtps::InstanceHandle_t;
using eprosima::fastrtps::rtps::SerializedPayload_t;

using Bytes = std::vector<std::uint8_t>;

// Any type as its encoded bytes.
class RawType : public fast::TopicDataType {
 public:
  explicit RawType(const std::string& name) {
    constexpr std::uint32_t kLargest = 4U << 20U;
    setName(name.c_str());
    m_typeSize = kLargest;
    m_isGetKeyDefined = false;
  }
  bool serialize(void* data, SerializedPayload_t* payload) override {
    const Bytes& bytes = *static_cast<Bytes*>(data);
    std::memcpy(payload->data, bytes.data(), bytes.size());
    payload->length = static_cast<std::uint32_t>(bytes.size());
    return true;
  }
  bool deserialize(SerializedPayload_t* payload, void* data) override {
    static_cast<Bytes*>(data)->assign(payload->data, payload->data + payload->length);
    return true;
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<std::uint32_t>(static_cast<Bytes*>(data)->size()); };
  }
  void* createData() override { return new Bytes; }
  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
  bool getKey(void*, InstanceHandle_t*, bool) override { return false; }
};

class Printer : public fast::DataReaderListener {
 public:
  void on_data_available(fast::DataReader* reader) override {
    Bytes bytes;
    fast::SampleInfo info;
    while (reader->take_next_sample(&bytes, &info) == ReturnCode_t::RETCODE_OK) {
      if (!info.valid_data) continue;
      std::uint64_t sum = 0;
      for (const std::uint8_t byte : bytes) sum += byte;
      std::cout << "received " << bytes.size() << " " << sum << std::endl;
    }
  }
};

int main(int argc, char** argv) {
  if (argc != 6) return EXIT_FAILURE;
  auto* const participant = fast::DomainParticipantFactory::get_instance()->create_participant(
      static_cast<std::uint32_t>(std::atoi(argv[1])), fast::PARTICIPANT_QOS_DEFAULT);
  if (participant == nullptr) return EXIT_FAILURE;
  const fast::TypeSupport type(new RawType(argv[2]));
  type.register_type(participant);
  auto* const out = participant->create_topic(argv[3], argv[2], fast::TOPIC_QOS_DEFAULT);
  auto* const in = participant->create_topic(argv[5], argv[2], fast::TOPIC_QOS_DEFAULT);
  fast::DataWriterQos written = fast::DATAWRITER_QOS_DEFAULT;
  written.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
  written.durability().kind = fast::TRANSIENT_LOCAL_DURABILITY_QOS;
  written.endpoint().history_memory_policy = eprosima::fastrtps::rtps::DYNAMIC_RESERVE_MEMORY_MODE;
  written.publish_mode().kind = fast::ASYNCHRONOUS_PUBLISH_MODE;  // for large samples
  fast::DataReaderQos read = fast::DATAREADER_QOS_DEFAULT;
  read.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
  read.durability().kind = fast::TRANSIENT_LOCAL_DURABILITY_QOS;
  read.endpoint().history_memory_policy = eprosima::fastrtps::rtps::DYNAMIC_RESERVE_MEMORY_MODE;
  Printer printer;
  auto* const writer =
      participant->create_publisher(fast::PUBLISHER_QOS_DEFAULT)->create_datawriter(out, written);
  auto* const reader = participant->create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT)
                           ->create_datareader(in, read, &printer);
  if (writer == nullptr || reader == nullptr) return EXIT_FAILURE;
  std::cout << "ready" << std::endl;
  std::ifstream file(argv[4], std::ios::binary);
  Bytes sample{std::istreambuf_iterator<char>(file), {}};
  if (!writer->write(&sample)) return EXIT_FAILURE;
  for (;;) pause();
}
