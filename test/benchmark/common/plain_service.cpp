#include "musher/test/benchmark/common/plain_service.hpp"

#include <cstdlib>
#include <optional>
#include <thread>

#include "musher/base/host.hpp"
#include "musher/test/benchmark/common/child.hpp"
#include "musher/transport/dds/settings.hpp"

namespace musher::benchmark {

PlainParticipant::PlainParticipant(int domain) {
  const std::string settings = transport::dds::SettingsXml(TransportProfile::kLocal, std::nullopt);
  const auto id = static_cast<dds_domainid_t>(domain);
  dds_create_domain(id, settings.c_str());  // or it exists already
  entity_ = dds_create_participant(id, nullptr, nullptr);
  if (entity_ < 0) Fail("no participant");
}

PlainParticipant::~PlainParticipant() {
  dds_delete(entity_);
}

PlainEnd::PlainEnd(const PlainParticipant& participant, const std::string& name, Role role,
                   std::function<void()> on_data)
    : role_(role), on_data_(std::move(on_data)) {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 10);
  const dds_entity_t requests =
      dds_create_topic(participant.get(), &musher_msgs_srv_dds__ActuatorCommand_Request__desc,
                       ("rq/plain/" + name + "Request").c_str(), nullptr, nullptr);
  const dds_entity_t replies =
      dds_create_topic(participant.get(), &musher_msgs_srv_dds__ActuatorCommand_Response__desc,
                       ("rr/plain/" + name + "Reply").c_str(), nullptr, nullptr);
  dds_listener_t* listener = dds_create_listener(this);
  if (on_data_) {
    dds_lset_data_available(
        listener, [](dds_entity_t, void* self) { static_cast<PlainEnd*>(self)->on_data_(); });
  }
  const bool client = role == Role::kClient;
  writer_ = dds_create_writer(participant.get(), client ? requests : replies, qos, nullptr);
  reader_ = dds_create_reader(participant.get(), client ? replies : requests, qos, listener);
  dds_delete_listener(listener);
  dds_delete_qos(qos);
  if (reader_ < 0 || writer_ < 0) Fail("no reader or writer");
}

PlainEnd::~PlainEnd() {
  dds_delete(reader_);
  dds_delete(writer_);
}

void PlainEnd::CallUntil(const std::function<bool()>& answered) const {
  do {
    Call(0);
    std::this_thread::sleep_for(Milliseconds(5));
  } while (!answered());
}

void PlainEnd::Call(std::int64_t sequence) const {
  static char target[] = "DeActive";
  PlainRequest request{};
  request.client_id = 1;
  request.sequence_number = sequence;
  request.target = target;
  Write(&request);
}

void PlainEnd::Answer(std::int64_t sequence) const {
  static char none[] = "", name[] = "a0", state[] = "DeActive", hash[] = "0123456789abcdef";
  static std::string host = HostId();
  PlainResponse response{};
  response.client_id = 1;
  response.sequence_number = sequence;
  response.message = none;
  response.status.name = name;
  response.status.state = state;
  response.status.target = none;
  response.status.outcome_message = none;
  response.status.host = host.data();
  response.status.config_hash = hash;
  Write(&response);
}

void PlainEnd::Write(const void* sample) const {
  if (dds_write(writer_, sample) != DDS_RETCODE_OK) Fail("dds_write");
}

std::int64_t PlainEnd::Take() const {
  void* loan = nullptr;
  dds_sample_info_t info;
  std::int64_t sequence = -1;
  while (sequence < 0 && dds_take(reader_, &loan, &info, 1, 1) == 1) {
    if (info.valid_data) {
      sequence = role_ == Role::kClient ? static_cast<const PlainResponse*>(loan)->sequence_number
                                        : static_cast<const PlainRequest*>(loan)->sequence_number;
    }
    dds_return_loan(reader_, &loan, 1);
  }
  return sequence;
}

PlainWaitset::PlainWaitset(const PlainParticipant& participant)
    : entity_(dds_create_waitset(participant.get())) {}

PlainWaitset::~PlainWaitset() {
  dds_delete(entity_);
}

void PlainWaitset::Attach(const PlainEnd& end, std::size_t index) {
  dds_set_status_mask(end.reader(), DDS_DATA_AVAILABLE_STATUS);
  dds_waitset_attach(entity_, end.reader(), static_cast<dds_attach_t>(index));
  ++size_;
}

std::vector<std::size_t> PlainWaitset::Wait() const {
  std::vector<dds_attach_t> ready(size_);
  const dds_return_t count = dds_waitset_wait(entity_, ready.data(), size_, DDS_INFINITY);
  return {ready.begin(), ready.begin() + count};
}

}  // namespace musher::benchmark
