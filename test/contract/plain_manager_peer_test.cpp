// CyberDog's manager as a plain C program meets it: idlc's types over real DDS, ROS 2's topic
// names, and no code of Musher.

#include <dds/dds.h>
#include <gmock/gmock.h>
#include <musher_idl.h>

#include <cstdlib>
#include <fstream>
#include <functional>
#include <memory>
#include <string>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/controller/machine_controller.hpp"
#include "musher/cyberdog/extension.hpp"
#include "musher/test/actuator/robot_file.hpp"

namespace musher::testing::plain_manager_peer_test {

using ::testing::HasSubstr;

// A C participant in the robot's domain, with ROS 2's QoS.
class PlainPeer {
 public:
  PlainPeer()
      : participant_(dds_create_participant(static_cast<dds_domainid_t>(transport::TestDomain()),
                                            nullptr, nullptr)),
        qos_(dds_create_qos()) {
    dds_qset_reliability(qos_, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
    dds_qset_history(qos_, DDS_HISTORY_KEEP_LAST, 10);
  }
  ~PlainPeer() {
    dds_delete_qos(qos_);
    dds_delete(participant_);
  }
  PlainPeer(const PlainPeer&) = delete;
  PlainPeer& operator=(const PlainPeer&) = delete;

  dds_entity_t Reader(const dds_topic_descriptor_t& type, const std::string& name) const {
    return dds_create_reader(participant_, Topic(type, name), qos_, nullptr);
  }
  dds_entity_t Writer(const dds_topic_descriptor_t& type, const std::string& name) const {
    return dds_create_writer(participant_, Topic(type, name), qos_, nullptr);
  }

 private:
  dds_entity_t Topic(const dds_topic_descriptor_t& type, const std::string& name) const {
    return dds_create_topic(participant_, &type, name.c_str(), nullptr, nullptr);
  }

  dds_entity_t participant_;
  dds_qos_t* qos_;
};

bool Eventually(const std::function<bool()>& done) {
  const dds_time_t end = dds_time() + DDS_SECS(20);
  while (!done()) {
    if (dds_time() > end) return false;
    dds_sleepfor(DDS_MSECS(5));  // a C peer that polls; what is waited for is the sample
  }
  return true;
}

// The next sample, on loan from its reader; null: there is none.
template <class T>
std::shared_ptr<T> Take(dds_entity_t reader) {
  void* loan = nullptr;
  dds_sample_info_t info;
  if (dds_take(reader, &loan, &info, 1, 1) != 1) return nullptr;
  std::shared_ptr<T> sample(static_cast<T*>(loan), [reader](void* taken) {
    static_cast<void>(dds_return_loan(reader, &taken, 1));
  });
  return info.valid_data ? sample : nullptr;
}

template <class Request, class Response>
class PlainClient {
 public:
  PlainClient(const PlainPeer& peer, const dds_topic_descriptor_t& request,
              const dds_topic_descriptor_t& response, const std::string& name)
      : writer_(peer.Writer(request, "rq/" + RobotFile::name_space() + "/" + name + "Request")),
        reader_(peer.Reader(response, "rr/" + RobotFile::name_space() + "/" + name + "Reply")) {}

  std::shared_ptr<Response> Call(Request request) {
    request.client_id = 4711;
    request.sequence_number = ++sequence_;
    const bool matched = Eventually([&] {
      dds_publication_matched_status_t there{};
      dds_subscription_matched_status_t back{};
      dds_get_publication_matched_status(writer_, &there);
      dds_get_subscription_matched_status(reader_, &back);
      return there.current_count > 0 && back.current_count > 0;
    });
    EXPECT_TRUE(matched);
    EXPECT_EQ(dds_write(writer_, &request), DDS_RETCODE_OK);
    std::shared_ptr<Response> answer;
    Eventually([&] {
      answer = Take<Response>(reader_);
      return answer && answer->client_id == 4711 && answer->sequence_number == sequence_;
    });
    return answer;
  }

 private:
  dds_entity_t writer_;
  dds_entity_t reader_;
  std::int64_t sequence_ = 0;
};

using Trigger =
    PlainClient<std_srvs_srv_dds__Trigger_Request_, std_srvs_srv_dds__Trigger_Response_>;

class ManagerOfPlainPeers : public ::testing::Test {
 protected:
  ManagerOfPlainPeers() : file_({"legs"}, kAllStates) {
    std::ofstream(file_.path(), std::ios::app)
        << "critical = true\n[policy]\nmanager = true\n[policy.power_off]\ndelay_s = 0\n"
        << "command = [\"touch\", \"" << Mark() << "\"]\n";
    legs_.RegisterStateCallback([](const State&) { return kCodeOk; });
  }
  ~ManagerOfPlainPeers() override { legs_.Shutdown(); }

  void BringUp() {
    ASSERT_TRUE(legs_.Init(file_.path()));
    ASSERT_TRUE(legs_.Start());
    ASSERT_TRUE(controller_.Init(file_.path()));
    ASSERT_TRUE(controller_.AwaitSetUp());
    ASSERT_TRUE(controller_.Switch("SelfCheck").done());
    ASSERT_TRUE(controller_.Switch("Active").done());
  }
  // What the power-off command leaves behind.
  std::string Mark() const { return file_.path() + ".off"; }
  std::shared_ptr<std_srvs_srv_dds__Trigger_Response_> Call(const std::string& name) {
    return Trigger(peer_, std_srvs_srv_dds__Trigger_Request__desc,
                   std_srvs_srv_dds__Trigger_Response__desc, name)
        .Call({});
  }

  RobotFile file_;
  PlainPeer peer_;
  ActuatorRunner<MachineActuator> legs_{"legs"};
  MachineController controller_{{cyberdog::Extension()}};
};

TEST_F(ManagerOfPlainPeers, PublishesItsStateAndKeepsIt) {
  ASSERT_NO_FATAL_FAILURE(BringUp());
  auto answer = Call("machine_state_valget");
  ASSERT_TRUE(answer);
  EXPECT_TRUE(answer->success);
  EXPECT_STREQ(answer->message, "active");
  PlainClient<protocol_srv_dds__MachineState_Request_, protocol_srv_dds__MachineState_Response_>
      keep(peer_, protocol_srv_dds__MachineState_Request__desc,
           protocol_srv_dds__MachineState_Response__desc, "machine_state_switch_keep");
  protocol_srv_dds__MachineState_Request_ request{};
  request.state = 1;  // Protected
  request.ticks = 600;
  auto kept = keep.Call(request);
  ASSERT_TRUE(kept);
  EXPECT_TRUE(kept->success);
  EXPECT_EQ(kept->code, 0);
  kept = keep.Call(request);
  ASSERT_TRUE(kept);
  EXPECT_TRUE(kept->success);
  EXPECT_EQ(kept->code, -1) << "it is kept already";
  EXPECT_EQ(controller_.GetMachineState(), "Protected");
}

TEST_F(ManagerOfPlainPeers, IsSwitchedByATopicAndPublishesIt) {
  const std::string ns = "rt/" + RobotFile::name_space() + "/";
  const dds_entity_t states =
      peer_.Reader(protocol_msg_dds__StateSwitchStatus__desc, ns + "state_switch_status");
  const dds_entity_t wanted =
      peer_.Writer(std_msgs_msg_dds__UInt8__desc, ns + "machine_state_switch");
  ASSERT_NO_FATAL_FAILURE(BringUp());
  ASSERT_TRUE(Eventually([&] {
    dds_publication_matched_status_t matched{};
    dds_get_publication_matched_status(wanted, &matched);
    return matched.current_count > 0;
  }));
  const std_msgs_msg_dds__UInt8_ low_power{2};
  ASSERT_EQ(dds_write(wanted, &low_power), DDS_RETCODE_OK);
  EXPECT_TRUE(Eventually([&] {
    const auto published = Take<protocol_msg_dds__StateSwitchStatus_>(states);
    return published && published->state == 2 && published->code == 0;
  }));
  EXPECT_TRUE(Eventually([&] { return controller_.GetMachineState() == "LowPower"; }));
}

TEST_F(ManagerOfPlainPeers, PowersOffByTheConfiguredCommandAfterTearDown) {
  ASSERT_NO_FATAL_FAILURE(BringUp());
  const auto answer = Call("poweroff");
  ASSERT_TRUE(answer);
  EXPECT_TRUE(answer->success) << answer->message;
  EXPECT_TRUE(Eventually([&] { return std::ifstream(Mark()).good(); }));
  EXPECT_EQ(legs_.Wait(), 0) << "it was torn down";
}

}  // namespace musher::testing::plain_manager_peer_test
