#include "musher/transport/dds/participant.hpp"

#include <dds/ddsrt/log.h>

#include <cstdlib>
#include <map>
#include <mutex>
#include <string_view>

#include "musher/base/output_thread.hpp"
#include "musher/transport/dds/log_sink.hpp"
#include "musher/transport/dds/peers.hpp"
#include "musher/transport/dds/qos.hpp"
#include "musher/transport/dds/security.hpp"
#include "musher/transport/dds/steady_waits.hpp"

namespace musher::transport::dds {

namespace {

// Collects what Cyclone logs during its lifetime: dds_create_domain() itself gives no reason. There
// is one sink in a process; needs the lock of OpenParticipant().
class LogCapture {
 public:
  LogCapture() { dds_set_log_sink(Append, this); }
  LogCapture(const LogCapture&) = delete;
  LogCapture& operator=(const LogCapture&) = delete;
  ~LogCapture() {
    dds_set_log_sink(LogOnceAMinute, nullptr);
    if (!text_.empty()) StandardError().Write(text_ + "\n");
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

constexpr const char* kPluginsHint =
    " (the plugins of DDS Security are libdds_security_auth.so, _ac.so and _crypto.so, of the "
    "Debian package libddsc0debian)";

// A domain has 250 UDP ports, from 7400 + 250 * its number on. Linux gives the ports 32768 to 60999
// to any socket without a fixed port.
bool SharesItsPorts(int domain_id) {
  return domain_id >= 102 && domain_id <= 214;
}

// A bad CYCLONEDDS_URI is not.
bool IsAboutPorts(const std::string& reason) {
  return reason.find("in use") != std::string::npos ||
         reason.find("participant index") != std::string::npos;
}

Error SetupError(int domain_id, dds_return_t code, LogCapture& log) {
  Error error = DdsError("cannot join DDS domain " + std::to_string(domain_id), code);
  if (const std::string reason = log.Take(); !reason.empty()) error.message += ": " + reason;
  if (SharesItsPorts(domain_id) && IsAboutPorts(error.message)) {
    error.message +=
        " (any program may hold a port of the domains 102 to 214: 0 to 101 and 215 to 232 have "
        "theirs to themselves)";
  }
  if (const char* uri = std::getenv("CYCLONEDDS_URI")) {
    error.message += " (CYCLONEDDS_URI is " + std::string(uri) + ")";
  }
  return error;
}

std::string NameOf(const std::optional<Credentials>& credentials) {
  return credentials ? credentials->identity + " of " + credentials->keys
                     : "a participant without credentials";
}

Result<Entity> OpenDomain(int domain_id, const std::string& settings, LogCapture& log) {
  if (settings.empty()) return Entity();
  const dds_entity_t entity =
      dds_create_domain(static_cast<dds_domainid_t>(domain_id), settings.c_str());
  // An existing domain was made by other code of this process, and is used as it is.
  if (entity < 0 && entity != DDS_RETCODE_PRECONDITION_NOT_MET) {
    return SetupError(domain_id, entity, log);
  }
  return Entity(entity);
}

Result<Participant*> Join(int domain_id, const std::string& settings,
                          const std::optional<Credentials>& credentials, RosDistro distro,
                          const std::string& name) {
  LinkSteadyWaits();
  LogCapture log;
  auto domain = OpenDomain(domain_id, settings, log);
  if (!domain) return domain.error();
  const QosPtr qos(dds_create_qos());
  // As a ROS 2 node without security; it ignores the second one.
  const std::string user_data = "enclave=/;" + std::string(kNameKey) + name + ";";
  dds_qset_userdata(qos.get(), user_data.data(), user_data.size());
  if (credentials) SetCredentials(qos.get(), *credentials);
  const dds_entity_t entity =
      dds_create_participant(static_cast<dds_domainid_t>(domain_id), qos.get(), nullptr);
  if (entity < 0) {
    Error error = SetupError(domain_id, entity, log);
    if (credentials) error.message += kPluginsHint;
    return error;
  }
  auto participant =
      std::make_unique<Participant>(std::move(domain).value(), Entity(entity), credentials, distro);
  // Keys made by an older Musher do not permit it; everything else works then.
  if (!participant->graph().open()) log.Take();
  return participant.release();
}

}  // namespace

ParticipantId Participant::IdOf(dds_entity_t participant) {
  dds_guid_t guid{};
  return dds_get_guid(participant, &guid) == DDS_RETCODE_OK ? IdOfParticipant(guid)
                                                            : ParticipantId(0);
}

Result<std::shared_ptr<Participant>> OpenParticipant(int domain_id, const std::string& settings,
                                                     const std::optional<Credentials>& credentials,
                                                     RosDistro distro, const std::string& name) {
  // A participant that is destroyed deletes its domain with everything that another thread has
  // opened in it meanwhile: so they are created and destroyed one after the other.
  static std::mutex mutex;
  static std::map<int, std::weak_ptr<Participant>> participants;
  std::shared_ptr<Participant> participant;  // may be the last; destroyed after the lock
  const std::lock_guard lock(mutex);
  participant = participants[domain_id].lock();
  if (!participant) {
    auto joined = Join(domain_id, settings, credentials, distro, name);
    if (!joined) return joined.error();
    participant.reset(joined.value(), [](Participant* last) {
      const std::lock_guard gone(mutex);
      delete last;
    });
    participants[domain_id] = participant;
  }
  if (participant->credentials() != credentials) {
    return Error{kCodeParametersInvalid,
                 "this process is in DDS domain " + std::to_string(domain_id) + " as " +
                     NameOf(participant->credentials()) + " already, and cannot be " +
                     NameOf(credentials) + " there, too"};
  }
  return participant;
}

}  // namespace musher::transport::dds
