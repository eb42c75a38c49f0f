#include "musher/modules/vision/course/course_config.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "musher/base/toml/names.hpp"
#include "musher/base/toml/rows.hpp"
#include "musher/modules/vision/course/course_parameters.hpp"

namespace musher::vision {
namespace {

namespace row = config_toml::row;
using config_toml::Findings;
using config_toml::Quote;
using config_toml::TableReader;
using config_toml::Value;

std::string DefaultPublish(CourseKind kind, const std::string& name) {
  switch (kind) {
    case CourseKind::kQr:
      return "qr_detector/qr_info";
    case CourseKind::kAruco:
      return "aruco_detector/word";
    case CourseKind::kNet:
      return "net_detector/label";
    case CourseKind::kArrow:
      return "green_arrow_detector/direction";
    case CourseKind::kBarrier:
      return "red_barrier_detector/distance";
    case CourseKind::kMarker:
      return "yellow_marker_detector/distance";
    case CourseKind::kLight:
      return "yellow_light_detector/distance";
    case CourseKind::kLines:
      return "yellow_line_detector/" + name;
  }
  return name;
}

// There an absolute topic and a relative one may be the same.
std::string InNoNamespace(const std::string& topic) {
  return topic.substr(topic.starts_with('/') ? 1 : 0);
}

// In messages a detector is called by its name.
std::string PathOf(const config_toml::Table& table) {
  const config_toml::Member* name = config_toml::Find(table, "name");
  const auto* text = name == nullptr ? nullptr : name->value.As<std::string>();
  return text != nullptr && config_toml::IsName(*text) ? "detectors." + *text : "detectors";
}

class EntriesReader {
 public:
  EntriesReader(Hall hall, Findings& findings, std::filesystem::path folder,
                const std::vector<std::string>& taken)
      : hall_(std::move(hall)), findings_(findings), folder_(std::move(folder)) {
    for (const std::string& topic : taken) publishers_[InNoNamespace(topic)] = "the face detection";
  }

  void Read(const Value& value) {
    const auto* table = value.As<config_toml::Table>();
    if (table == nullptr) return;  // reported by Tables()
    const std::string path = PathOf(*table);
    TableReader reader(*table, value.at, path, findings_);
    CourseEntry entry;
    ReadName(reader, entry);
    const auto kind = ReadKind(reader);
    row::Topic("picture", entry.picture, "image_rgb")(reader);
    row::Topic("camera_info", entry.camera_info, "image_rgb")(reader);
    if (const auto degrees = reader.Number("hfov_deg", 1, 170)) {
      entry.hfov_rad = *degrees * M_PI / 180;
    }
    entry.rate_hz = reader.Number("rate_hz", 0, 1000).value_or(entry.rate_hz);
    row::Topic("publish", entry.publish, "image_rgb")(reader);
    entry.limits.hang = reader.Time("hang_ms").value_or(entry.limits.hang);
    if (const auto failures = reader.Integer("failures", 1, 1000)) {
      entry.limits.failures = static_cast<int>(*failures);
    }
    const config_toml::Table* parameters = reader.SubTable("parameters");
    reader.RefuseOthers();
    if (!kind) return;
    entry.kind = *kind;
    if (entry.publish.empty()) entry.publish = DefaultPublish(*kind, entry.name);
    const config_toml::Table none;
    TableReader parameter_reader(parameters == nullptr ? none : *parameters,
                                 reader.At("parameters"), path + ".parameters", findings_);
    entry.parameters =
        ReadCourseParameters(*kind, hall_, entry.picture, folder_, parameter_reader, findings_);
    entry.balance = hall_.balance;
    entry.factory = FactoryOf(entry.parameters, entry.balance);
    if (parameters != nullptr) ReadOwnColor(*parameters, parameter_reader, entry);
    parameter_reader.RefuseOthers();
    CheckOutputs(reader, entry);
    entries_.push_back(std::move(entry));
  }

  std::vector<CourseEntry> Take() && { return std::move(entries_); }

 private:
  void ReadName(TableReader& reader, CourseEntry& entry) {
    reader.Require("name", "a name, as in \"qr_detector\"");
    const auto name = reader.String("name");
    if (!name) return;
    if (!config_toml::IsName(name->text)) {
      reader.Fault(
          name->at, "name",
          "expected " + std::string(config_toml::kNameRule) + ", found " + Quote(name->text));
      return;
    }
    const auto [first, is_new] = name_lines_.emplace(name->text, name->at.line);
    if (!is_new) {
      reader.Fault(name->at, "name",
                   Quote(name->text) + " is the name of the detector in line " +
                       std::to_string(first->second) + " already");
    }
    entry.name = name->text;
  }

  // One beside that of the hall is most often forgotten there; only an amber light needs it.
  void ReadOwnColor(const config_toml::Table& parameters, TableReader& reader, CourseEntry& entry) {
    const std::string key = ColorKeyOf(entry.kind);
    entry.own_color = !key.empty() && config_toml::Find(parameters, key) != nullptr;
    entry.own_region =
        !RegionKeyOf(entry.kind).empty() && config_toml::Find(parameters, "region") != nullptr;
    if (!entry.own_color || entry.kind == CourseKind::kLight || !hall_.HasColor(key)) return;
    reader.Warn(reader.At(key), key,
                "wins over that of [hall]; remove it, unless this detector needs one of its own");
  }

  static std::optional<CourseKind> ReadKind(TableReader& reader) {
    reader.Require("kind",
                   R"("qr", "aruco", "arrow", "barrier", "marker", "light", "lines" or "net")");
    return reader.Choice<CourseKind>("kind", {{"qr", CourseKind::kQr},
                                              {"aruco", CourseKind::kAruco},
                                              {"arrow", CourseKind::kArrow},
                                              {"barrier", CourseKind::kBarrier},
                                              {"marker", CourseKind::kMarker},
                                              {"light", CourseKind::kLight},
                                              {"lines", CourseKind::kLines},
                                              {"net", CourseKind::kNet}});
  }

  void CheckOutputs(TableReader& reader, const CourseEntry& entry) {
    for (const std::string& topic : entry.Outputs().All()) {
      const auto [first, is_new] = publishers_.emplace(
          InNoNamespace(topic), entry.name.empty() ? "another detector" : Quote(entry.name));
      if (is_new) continue;
      reader.Fault(reader.At("publish"), "publish",
                   "the topic " + Quote(topic) + " is published by " + first->second + " already");
      return;
    }
  }

  const Hall hall_;
  Findings& findings_;
  const std::filesystem::path folder_;
  std::map<std::string, int> name_lines_;
  std::map<std::string, std::string> publishers_;  // of each topic, as in no namespace
  std::vector<CourseEntry> entries_;
};

}  // namespace

std::string ColorKeyOf(CourseKind kind) {
  switch (kind) {
    case CourseKind::kLines:
    case CourseKind::kMarker:
    case CourseKind::kLight:
      return "yellow";
    case CourseKind::kArrow:
      return "green";
    case CourseKind::kBarrier:
      return "red";
    case CourseKind::kQr:
    case CourseKind::kAruco:
    case CourseKind::kNet:
      break;
  }
  return "";
}

std::string RegionKeyOf(CourseKind kind) {
  switch (kind) {
    case CourseKind::kArrow:
      return "arrow";
    case CourseKind::kBarrier:
      return "barrier";
    case CourseKind::kMarker:
      return "marker";
    case CourseKind::kLight:
      return "light";
    case CourseKind::kLines:
    case CourseKind::kQr:
    case CourseKind::kAruco:
    case CourseKind::kNet:
      break;
  }
  return "";
}

std::vector<std::string> CourseOutputs::All() const {
  std::vector<std::string> all;
  for (const auto& topic : {text, sighting, doubt, lines}) {
    if (topic) all.push_back(*topic);
  }
  all.push_back(debug_image);
  return all;
}

CourseOutputs CourseEntry::Outputs() const {
  CourseOutputs outputs;
  if (kind == CourseKind::kLines) {
    outputs.lines = publish;
    outputs.debug_image = publish + "/debug_image";
    return outputs;
  }
  const std::size_t slash = publish.rfind('/');
  const std::string first = slash == std::string::npos ? "" : publish.substr(0, slash + 1);
  outputs.text = publish;
  outputs.sighting = first + "sighting";
  outputs.doubt = first + "doubt";
  outputs.debug_image = first + "debug_image";
  return outputs;
}

std::vector<CourseEntry> ReadCourseEntries(TableReader& root, Findings& findings,
                                           const std::filesystem::path& folder,
                                           const std::vector<std::string>& taken) {
  EntriesReader reader(ReadHall(root, findings), findings, folder, taken);
  for (const Value* value : root.Tables("detectors")) reader.Read(*value);
  return std::move(reader).Take();
}

}  // namespace musher::vision
