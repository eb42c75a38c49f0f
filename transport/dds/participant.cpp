#include "musher/transport/dds/participant.hpp"

#include <dds/ddsrt/log.h>

#include <cstdio>
#include <cstdlib>
#include <map>
#include <mutex>
#include <string_view>

#include "musher/transport/dds/qos.hpp"

namespace musher::transport::dds {

namespace {

// Collects what Cyclone logs while it is there: dds_create_domain() says only that it failed. There
// is one sink in a process; needs the lock of OpenParticipant().
class LogCapture {
 public:
  LogCapture() { dds_set_log_sink(Append, this); }
  LogCapture(const LogCapture&) = delete;
  LogCapture& operator=(const LogCapture&) = delete;
  ~LogCapture() {
    dds_set_log_sink(nullptr, nullptr);
    if (!text_.empty()) std::fprintf(stderr, "%s\n", text_.c_str());
  }

  std::string Take() { return std::exchange(text_, {}); }

 private:
  static void Append(void* self, const dds_log_data_t* data) {
    std::string& text = static_cast<LogCapture*>(self)->text_;
    std::string_view line(data->message, data->size);
    while (!line.empty() && line.back() == '\n') line.remove_suffix(1);
    if (!text.empty()) text += "; ";
    text += line;
  }

  std::string text_;
};

Error SetupError(int domain_id, dds_return_t code, LogCapture& log) {
  Error error = DdsError("cannot join DDS domain " + std::to_string(domain_id), code);
  if (const std::string reason = log.Take(); !reason.empty()) error.message += ": " + reason;
  if (const char* uri = std::getenv("CYCLONEDDS_URI")) {
    error.message += " (CYCLONEDDS_URI is " + std::string(uri) + ")";
  }
  return error;
}

bool UserHasSettings() {
  const char* uri = std::getenv("CYCLONEDDS_URI");
  return uri != nullptr && *uri != '\0';
}

}  // namespace

Result<Participant> OpenParticipant(int domain_id, const std::string& settings) {
  static std::mutex mutex;
  static std::map<int, std::weak_ptr<Entity>> domains;
  const std::lock_guard lock(mutex);
  LogCapture log;

  Participant participant;
  participant.domain = domains[domain_id].lock();
  if (!participant.domain && !UserHasSettings()) {
    const dds_entity_t domain =
        dds_create_domain(static_cast<dds_domainid_t>(domain_id), settings.c_str());
    // One that exists was made by other code of this process, and is used as it is.
    if (domain < 0 && domain != DDS_RETCODE_PRECONDITION_NOT_MET) {
      return SetupError(domain_id, domain, log);
    }
    participant.domain = std::make_shared<Entity>(domain);
    domains[domain_id] = participant.domain;
  }

  const QosPtr qos(dds_create_qos());
  constexpr std::string_view kEnclave = "enclave=/;";  // as a ROS 2 node without security
  dds_qset_userdata(qos.get(), kEnclave.data(), kEnclave.size());
  const dds_entity_t entity =
      dds_create_participant(static_cast<dds_domainid_t>(domain_id), qos.get(), nullptr);
  if (entity < 0) return SetupError(domain_id, entity, log);
  participant.entity = Entity(entity);
  return participant;
}

}  // namespace musher::transport::dds
