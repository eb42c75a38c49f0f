#pragma once
// The fixture of the wire tests: our structs against a plain C program that has nothing but the
// IDL. Every message type goes to it over real DDS, is compared field by field, and comes back.

#include <dds/dds.h>
#include <gtest/gtest.h>

#include <string>

#include "musher/test/contract/fill.hpp"
#include "musher/test/contract/wire_same.hpp"
#include "musher/test/contract/world.hpp"
#include "musher/test/support/domain.hpp"

namespace musher::transport {

using msg::Same;

// A service's sample: the id comes before the body.
template <class Body>
struct Envelope {
  msg::RequestId id;
  Body body;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.id, m.body);
  }
  friend bool operator==(const Envelope&, const Envelope&) = default;
};

template <class C, class Body>
void SameSample(const C& c, const Envelope<Body>& m) {
  EXPECT_EQ(c.client_id, m.id.client);
  EXPECT_EQ(c.sequence_number, m.id.sequence);
  Same(c, m.body, "");
}
template <class C, class M>
void SameSample(const C& c, const M& m) {
  Same(c, m, "");
}

// A plain C program with a topic of its own: an idlc type, default QoS, reliable.
class Peer {
 public:
  Peer(const std::string& topic, const dds_topic_descriptor_t& type)
      : participant_(
            dds_create_participant(static_cast<dds_domainid_t>(TestDomain()), nullptr, nullptr)) {
    dds_qos_t* qos = dds_create_qos();
    dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
    reader_ = dds_create_reader(participant_, Topic(type, topic + "/to_c"), qos, nullptr);
    writer_ = dds_create_writer(participant_, Topic(type, topic + "/from_c"), qos, nullptr);
    dds_delete_qos(qos);
  }
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;
  ~Peer() { dds_delete(participant_); }

  // The next sample, on loan from Cyclone until GiveBack().
  const void* Take() {
    dds_sample_info_t info;
    loan_ = nullptr;
    const bool taken = dds_take(reader_, &loan_, &info, 1, 1) == 1 && info.valid_data;
    return taken ? loan_ : nullptr;
  }
  void GiveBack() { dds_return_loan(reader_, &loan_, 1); }
  void Write(const void* sample) { EXPECT_EQ(dds_write(writer_, sample), DDS_RETCODE_OK); }

 private:
  dds_entity_t Topic(const dds_topic_descriptor_t& type, const std::string& name) const {
    return dds_create_topic(participant_, &type, name.c_str(), nullptr, nullptr);
  }

  dds_entity_t participant_;
  dds_entity_t reader_ = 0;
  dds_entity_t writer_ = 0;
  void* loan_ = nullptr;
};

// A type as the test needs it. Functions without a type in their signature keep the exchange itself
// out of the template, which is instantiated some three hundred times.
struct ExchangedType {
  msg::Bytes (*encoded)(unsigned round);
  void (*compare)(const void* c_sample, unsigned round);
  bool (*came_back)(const msg::Bytes& bytes, unsigned round);
};

template <class C, class M>
ExchangedType ExchangedTypeOf() {
  return {[](unsigned round) { return msg::Encode(msg::Filled<M>(round)); },
          [](const void* sample, unsigned round) {
            SameSample(*static_cast<const C*>(sample), msg::Filled<M>(round));
          },
          [](const msg::Bytes& bytes, unsigned round) {
            return msg::Decode<M>(bytes) == msg::Filled<M>(round);
          }};
}

class Wire : public ::testing::Test {
 protected:
  void Exchange(const dds_topic_descriptor_t& type, const ExchangedType& exchanged) {
    static int number = 0;
    const std::string topic = "wire_" + std::to_string(getpid()) + "_" + std::to_string(++number);
    Peer peer(topic, type);
    msg::Bytes back;
    ReaderCallbacks callbacks;
    callbacks.on_sample = [&](std::span<const std::byte> bytes, const SampleInfo&) {
      back.assign(bytes.begin(), bytes.end());
    };
    const auto writer = Must(node_->MakeRawWriter(topic + "/to_c", type.m_typename, {}, {}));
    const auto reader =
        Must(node_->MakeRawReader(topic + "/from_c", type.m_typename, {}, std::move(callbacks)));
    ASSERT_TRUE(world_->RunUntil(
        [&] { return writer->MatchedReaders() == 1 && reader->MatchedWriters() == 1; }));
    for (unsigned round = 0; round < msg::kFillRounds; ++round) {
      ASSERT_TRUE(writer->Write(exchanged.encoded(round)));
      const void* sample = nullptr;
      ASSERT_TRUE(world_->RunUntil([&] { return (sample = peer.Take()) != nullptr; }));
      exchanged.compare(sample, round);
      back.clear();
      peer.Write(sample);
      peer.GiveBack();
      ASSERT_TRUE(world_->RunUntil([&] { return !back.empty(); }));
      EXPECT_TRUE(exchanged.came_back(back, round)) << type.m_typename << ", round " << round;
    }
  }

  // For a message: its name on the wire is Musher's, too.
  template <class C, class M>
  void ExchangeMessage(const dds_topic_descriptor_t& type) {
    EXPECT_EQ(type.m_typename, M::kTypeName);
    Exchange(type, ExchangedTypeOf<C, M>());
  }

  // For a service: both samples with their ids.
  template <class CRequest, class CResponse, class S>
  void ExchangeService(const dds_topic_descriptor_t& request,
                       const dds_topic_descriptor_t& response) {
    EXPECT_EQ(request.m_typename, std::string(S::kTypeName) + "Request_");
    EXPECT_EQ(response.m_typename, std::string(S::kTypeName) + "Response_");
    Exchange(request, ExchangedTypeOf<CRequest, Envelope<typename S::Request>>());
    Exchange(response, ExchangedTypeOf<CResponse, Envelope<typename S::Response>>());
  }

 private:
  std::unique_ptr<World> world_ = MakeDdsWorld();
  std::unique_ptr<Node> node_ = world_->MakeNode();
  // Samples that come to the peer do not wake our loop.
  LoopHandlePtr ticker_ = world_->loop().Every(Milliseconds(1), [] {});
};

}  // namespace musher::transport
