#include "musher/behavior/tree/models.hpp"

#include <algorithm>
#include <array>

#include "musher/behavior/tree/model_types.hpp"

namespace musher::tree {
namespace {

constexpr std::array kKinds = {NodeKind::kAction, NodeKind::kCondition, NodeKind::kDecorator,
                               NodeKind::kControl};

std::vector<std::string> NamesOf(const Factory& factory, NodeKind kind) {
  std::vector<std::string> names = factory.Names();
  std::erase_if(names, [&](const std::string& name) { return factory.Find(name)->kind != kind; });
  return names;
}

std::string XmlEscaped(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '&':
        escaped += "&amp;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? ' ' : c;
    }
  }
  return escaped;
}

std::string PortXml(const PortModel& port) {
  const std::string_view element = PortElement(port.direction);
  const std::string type = TypeNameOf(port);
  std::string text = "      <" + std::string(element) + " name=\"" + XmlEscaped(port.name) + "\"";
  if (!type.empty()) text += " type=\"" + XmlEscaped(type) + "\"";
  // An input that may be missing has an empty default: without one it has to be set.
  if (!port.otherwise.empty() || (port.direction == Direction::kIn && !port.required)) {
    text += " default=\"" + XmlEscaped(port.otherwise) + "\"";
  }
  if (port.doc.empty()) return text + "/>\n";
  return text + ">" + XmlEscaped(port.doc) + "</" + std::string(element) + ">\n";
}

std::string_view Does(const Factory& factory, const std::string& name) {
  const std::string& own = factory.Find(name)->description;
  return own.empty() ? DescriptionOf(name) : std::string_view(own);
}

std::string NodeXml(const Factory& factory, const std::string& name, NodeKind kind) {
  const std::string element(Name(kind));
  std::string inside;
  for (const PortModel& port : factory.PortsOf(name)) inside += PortXml(port);
  const std::string_view does = Does(factory, name);
  std::string fields;
  const auto add = [&fields](std::string_view field, std::string_view value) {
    fields += "        <Metadata " + std::string(field) + "=\"" + XmlEscaped(value) + "\"/>\n";
  };
  if (!does.empty()) add("description", does);
  for (const auto& [field, value] : factory.Find(name)->metadata) add(field, value);
  if (!fields.empty()) {
    inside += "      <MetadataFields>\n" + fields + "      </MetadataFields>\n";
  }
  const std::string begin = "    <" + element + " ID=\"" + XmlEscaped(name) + "\"";
  return inside.empty() ? begin + "/>\n" : begin + ">\n" + inside + "    </" + element + ">\n";
}

// A cell of a table.
std::string Cell(std::string_view text) {
  std::string cell;
  for (const char c : text) cell += c == '|' ? std::string("\\|") : std::string(1, c);
  return cell;
}

std::string PortRow(const PortModel& port) {
  std::string direction = "in";
  if (port.direction == Direction::kOut) direction = "out";
  if (port.direction == Direction::kInOut) direction = "in and out";
  const std::string type = port.direction == Direction::kText ? "fixed text"
                           : port.type == nullptr             ? "any"
                                                              : std::string(port.type->name);
  std::string otherwise = "–";
  if (port.required) otherwise = "has to be set";
  if (!port.otherwise.empty()) otherwise = "`" + port.otherwise + "`";
  return "| `" + port.name + "` | " + direction + " | " + Cell(type) + " | " + otherwise + " | " +
         Cell(port.doc) + " |\n";
}

}  // namespace

std::string_view PortElement(Direction direction) {
  switch (direction) {
    case Direction::kOut:
      return "output_port";
    case Direction::kInOut:
      return "inout_port";
    default:
      return "input_port";
  }
}

std::string ModelsXml(const Factory& factory) {
  std::string text = "<root BTCPP_format=\"4\">\n  <TreeNodesModel>\n";
  for (const NodeKind kind : kKinds) {
    for (const std::string& name : NamesOf(factory, kind)) text += NodeXml(factory, name, kind);
  }
  return text + "  </TreeNodesModel>\n</root>\n";
}

std::string ModelsMarkdown(const Factory& factory) {
  constexpr std::array<std::string_view, 4> kTitles = {"Actions", "Conditions", "Decorators",
                                                       "Controls"};
  std::string text;
  for (std::size_t i = 0; i < kKinds.size(); ++i) {
    const std::vector<std::string> names = NamesOf(factory, kKinds[i]);
    if (names.empty()) continue;
    text += "## " + std::string(kTitles[i]) + "\n\n";
    for (const std::string& name : names) {
      text += "### `" + name + "`\n\n";
      const std::string_view does = Does(factory, name);
      if (!does.empty()) text += std::string(does) + "\n\n";
      for (const auto& [field, value] : factory.Find(name)->metadata) {
        text += field + ": " + value + "\n\n";
      }
      const std::vector<PortModel> ports = factory.PortsOf(name);
      if (ports.empty()) continue;
      text += "| port | direction | type | default | meaning |\n|---|---|---|---|---|\n";
      for (const PortModel& port : ports) text += PortRow(port);
      text += "\n";
    }
  }
  if (!text.empty()) text.pop_back();
  return text;
}

}  // namespace musher::tree
