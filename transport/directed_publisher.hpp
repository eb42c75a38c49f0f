#pragma once
// A publisher of commands to one program, which is known by what it offers itself. A topic may have
// other readers, such as a recorder, and one of them may be discovered first: what is published
// then does not reach the program.
//
//   const auto publisher = MakeDirectedPublisher<msg::String>(
//       node, "state_machine/start_command", PublisherOf<msg::String>("state_machine/state_info"));
//   … wait until publisher.value()->Ready(), then Publish()
//
// Threads: loop thread only.

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "musher/transport/node.hpp"
#include "musher/transport/service.hpp"
#include "musher/transport/service_names.hpp"

namespace musher::transport {

// A topic that only the program writes, as DDS names.
struct ProgramMark {
  std::string topic;
  std::string type;
};

template <msg::Service S>
ProgramMark ServerOf(const std::string& service) {
  return {ReplyTopic(service), ResponseType(std::string(S::kTypeName))};
}
template <msg::Message M>
ProgramMark PublisherOf(const std::string& topic) {
  return {"rt/" + topic, std::string(M::kTypeName)};
}

template <msg::Message M>
class DirectedPublisher {
 public:
  DirectedPublisher(std::unique_ptr<RawWriter> writer, std::unique_ptr<RawReader> mark)
      : writer_(std::move(writer)), mark_(std::move(mark)) {}

  // Whether the program receives what is published now.
  bool Ready() const {
    const std::vector<ParticipantId> programs = mark_->WriterParticipants();
    return std::any_of(programs.begin(), programs.end(),
                       [this](ParticipantId program) { return writer_->HasReaderOf(program); });
  }
  Result<> Publish(const M& message) { return writer_->Write(msg::Encode(message)); }
  // Blocks until all matched readers have all samples; for a program that then exits.
  Result<> Flush(Duration timeout) { return writer_->Flush(timeout); }

 private:
  std::unique_ptr<RawWriter> writer_;
  std::unique_ptr<RawReader> mark_;
};

template <msg::Message M>
Result<std::unique_ptr<DirectedPublisher<M>>> MakeDirectedPublisher(Node& node,
                                                                    const std::string& topic,
                                                                    const ProgramMark& program,
                                                                    const Qos& qos = kDefaultQos) {
  ReaderCallbacks callbacks;
  callbacks.on_sample = [](auto, const SampleInfo&) {};
  // Best effort: matches a writer of any profile.
  auto mark = node.MakeRawReader(program.topic, program.type, kSensorDataQos, std::move(callbacks));
  if (!mark) return mark.error();
  auto writer = node.MakeRawWriter("rt/" + topic, std::string(M::kTypeName), qos, {});
  if (!writer) return writer.error();
  return std::make_unique<DirectedPublisher<M>>(std::move(writer).value(), std::move(mark).value());
}

}  // namespace musher::transport
