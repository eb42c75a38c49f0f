#include "musher/view/record/recording_file.hpp"

#include "musher/base/version.hpp"
#include "musher/view/mcap/scan.hpp"
#include "musher/view/record/qos_text.hpp"
#include "musher/view/record/schema.hpp"
#include "musher/view/topics/type_names.hpp"

namespace musher::view {

std::string MusherLibrary() {
  return "musher " + std::string(Version());
}

bool IsByMusher(const std::string& path) {
  return mcap::LibraryOf(path).starts_with("musher");
}

Result<std::unique_ptr<RecordingFile>> RecordingFile::Open(const std::string& path,
                                                           mcap::Compression compression) {
  mcap::WriterOptions options;
  options.compression = compression;
  options.library = MusherLibrary();
  auto writer = mcap::Writer::Open(path, options);
  if (!writer) return writer.error();
  return std::unique_ptr<RecordingFile>(new RecordingFile(std::move(writer).value()));
}

std::uint16_t RecordingFile::SchemaOf(const std::string& type) {
  const auto known = schemas_.find(type);
  if (known != schemas_.end()) return known->second;
  const std::string text = SchemaText(type);
  const std::string name = RosType(type);
  std::uint16_t id = 0;
  if (!text.empty()) id = writer_->AddSchema(name, "ros2msg", text);
  return schemas_[type] = id;
}

Result<> RecordingFile::Write(const RecordedChannel& declared, std::size_t channel,
                              std::int64_t log_ns, std::int64_t publish_ns,
                              const msg::Bytes& data) {
  Channel& known = channels_[channel];
  if (known.id == 0) {
    std::map<std::string, std::string> metadata;
    if (!declared.offered_qos.empty()) metadata[kOfferedQos] = declared.offered_qos;
    const std::uint16_t schema = SchemaOf(declared.type);
    if (schema == 0) metadata[kTypeOfUnknown] = declared.type;
    known.id = writer_->AddChannel(schema, declared.topic, "cdr", metadata);
  }
  return writer_->Write(known.id, known.sequence++, log_ns, publish_ns, data);
}

}  // namespace musher::view
