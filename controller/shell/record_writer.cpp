#include "musher/controller/shell/record_writer.hpp"

#include <utility>

#include "musher/controller/journal/record_data.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher {
namespace {

constexpr std::size_t kSwitchEntriesKept = 128;  // two for each switch: begin and end

}  // namespace

RecordWriter::RecordWriter(transport::EventLoop& loop, JournalSink& journal,
                           std::function<std::int64_t()> wall_ns, const MachineConfig& config,
                           const Machine& machine, OnRecord on_record)
    : loop_(loop),
      journal_(journal),
      wall_ns_(std::move(wall_ns)),
      config_(config),
      machine_(machine),
      on_record_(std::move(on_record)) {}

void RecordWriter::Write(const action::Record& record) {
  JournalEntry entry;
  entry.wall_ns = wall_ns_();
  entry.steady_ns = transport::ToNanoseconds(loop_.Now());
  entry.epoch = machine_.epoch;
  entry.switch_number = record.switch_number;
  entry.kind = record.kind;
  if (record.actuator) entry.actuator = config_.actuators[*record.actuator].name;
  entry.code = record.code;
  entry.message = record.message;
  entry.data = DataOf(record);
  entry.id = record.id;
  entry.cause = record.cause;
  entry.state = record.state;
  entry.event = NameOf(record.event);
  if (record.of_switch) {
    if (switches_.size() == kSwitchEntriesKept) switches_.erase(switches_.begin());
    switches_.push_back(entry);
  }
  journal_.Append(std::move(entry));
  if (on_record_) on_record_(record);
}

void RecordWriter::WriteOwn(const std::string& kind, std::optional<ActuatorIndex> actuator,
                            std::int32_t code, const RecordText& text) {
  action::Record record{kind, actuator, 0, code, text.message};
  record.event = text.event;
  record.arguments = text.arguments;
  Write(record);
}

void RecordWriter::Remark(std::int32_t code, const std::string& message) {
  WriteOwn("machine", std::nullopt, code, {EventName::kControllerRemark, message});
}

}  // namespace musher
