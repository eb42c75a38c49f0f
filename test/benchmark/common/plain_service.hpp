#pragma once
// The command service of an actuator with nothing but Cyclone's C API and idlc's types: same names,
// QoS, sizes and settings as Musher's, so that the cost of Musher is separate from the cost of DDS.

#include <dds/dds.h>
#include <musher_idl.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace musher::benchmark {

using PlainRequest = musher_msgs_srv_dds__ActuatorCommand_Request_;
using PlainResponse = musher_msgs_srv_dds__ActuatorCommand_Response_;

class PlainParticipant {
 public:
  explicit PlainParticipant(int domain);
  PlainParticipant(const PlainParticipant&) = delete;
  PlainParticipant& operator=(const PlainParticipant&) = delete;
  ~PlainParticipant();

  dds_entity_t get() const { return entity_; }

 private:
  dds_entity_t entity_;
};

// One side of the service: what it reads and what it writes.
class PlainEnd {
 public:
  enum class Role { kClient, kServer };

  // `on_data` runs on Cyclone's thread; without it a waitset or Take() is used.
  PlainEnd(const PlainParticipant& participant, const std::string& name, Role role,
           std::function<void()> on_data = {});
  PlainEnd(const PlainEnd&) = delete;
  PlainEnd& operator=(const PlainEnd&) = delete;
  ~PlainEnd();

  dds_entity_t reader() const { return reader_; }
  // Calls with sequence number 0 until there is a reply. Being matched would not be enough: the
  // server may not have discovered the reader yet, and its reply would be lost.
  void CallUntil(const std::function<bool()>& answered) const;

  // A command with the sequence number as the client sends it, and the reply to it.
  void Call(std::int64_t sequence) const;
  void Answer(std::int64_t sequence) const;

  // The sequence number of the next sample; -1 when there is none.
  std::int64_t Take() const;

 private:
  void Write(const void* sample) const;

  Role role_;
  std::function<void()> on_data_;
  dds_entity_t reader_ = 0;
  dds_entity_t writer_ = 0;
};

// Waits until some of the ends attached to it have data.
class PlainWaitset {
 public:
  explicit PlainWaitset(const PlainParticipant& participant);
  PlainWaitset(const PlainWaitset&) = delete;
  PlainWaitset& operator=(const PlainWaitset&) = delete;
  ~PlainWaitset();

  void Attach(const PlainEnd& end, std::size_t index);
  // The indices of those that have.
  std::vector<std::size_t> Wait() const;

 private:
  dds_entity_t entity_;
  std::size_t size_ = 0;
};

}  // namespace musher::benchmark
