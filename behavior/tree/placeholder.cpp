// Nodes that only their model describes.

#include <algorithm>
#include <array>
#include <cctype>
#include <stdexcept>
#include <utility>

#include "musher/base/suggest.hpp"
#include "musher/behavior/tree/model_types.hpp"
#include "musher/behavior/tree/models.hpp"

namespace musher::tree {
namespace {

struct TypeName {
  const Type* type = nullptr;
  std::string_view name;
};

// The first name of a type is the one that is written.
const std::vector<TypeName>& TypeNames() {
  static const std::vector<TypeName> names = {
      {TypeOf<std::string>(), "std::string"},
      {TypeOf<std::string>(), "string"},
      {TypeOf<bool>(), "bool"},
      {TypeOf<int>(), "int"},
      {TypeOf<int>(), "int32_t"},
      {TypeOf<unsigned>(), "unsigned int"},
      {TypeOf<unsigned>(), "unsigned"},
      {TypeOf<unsigned>(), "uint32_t"},
      {TypeOf<std::int64_t>(), "int64_t"},
      {TypeOf<std::int64_t>(), "long"},
      {TypeOf<std::uint64_t>(), "uint64_t"},
      {TypeOf<std::uint64_t>(), "unsigned long"},
      {TypeOf<double>(), "double"},
      {TypeOf<float>(), "float"},
      {TypeOf<Status>(), "BT::NodeStatus"},
      {TypeOf<Status>(), "NodeStatus"},
      {TypeOf<std::vector<double>>(), "std::vector<double>"},
      {TypeOf<std::vector<int>>(), "std::vector<int>"},
      {TypeOf<std::vector<std::string>>(), "std::vector<std::string>"},
  };
  return names;
}

// A port as its model declares it.
struct ModelPort {
  PortModel port;
  bool has_default = false;
};

// Whether the text may be the name of a number, which only the program knows.
bool MayBeEnum(const Type& type, std::string_view text) {
  const bool number =
      type.from_number != nullptr && &type != TypeOf<bool>() && &type != TypeOf<Status>();
  return number && !text.empty() && std::isalpha(static_cast<unsigned char>(text[0])) != 0;
}

void CheckText(Setup& setup, const PortModel& port, std::string_view text) {
  if (port.type == nullptr) return;
  const bool may_be_enum = MayBeEnum(*port.type, text);
  const bool whole = port.type != TypeOf<double>() && port.type != TypeOf<float>();
  if (may_be_enum && whole) return;  // enums are whole numbers
  Value value;
  const Result<> read = value.SetTextAs(*port.type, text);
  if (read) return;
  setup.Report(port.name, may_be_enum ? Severity::kWarning : Severity::kError,
               "port '" + port.name + "': " + read.error().message +
                   (may_be_enum ? ", or the name of an enum that the program has" : ""));
}

void MakePorts(Setup& setup, const std::vector<ModelPort>& ports) {
  for (const ModelPort& each : ports) {
    const PortModel& port = each.port;
    const Setup::Connection connection = setup.Connect(port);
    if (connection.text != nullptr) CheckText(setup, port, connection.text->value);
    const bool is_missing = connection.text == nullptr && connection.entry == nullptr;
    if (is_missing && port.direction == Direction::kIn && !each.has_default) {
      setup.NoteUnset(port.name);
    }
  }
}

// Base: what a node of the kind derives from.
template <class Base>
class Placeholder : public Base {
 private:
  Status OnTick(Tick&) override {
    throw std::runtime_error("the node is a placeholder of a model; its program has the node");
  }
};

std::unique_ptr<Node> MakePlaceholder(NodeKind kind) {
  if (kind == NodeKind::kControl) return std::make_unique<Placeholder<Control>>();
  if (kind == NodeKind::kDecorator) return std::make_unique<Placeholder<Decorator>>();
  return std::make_unique<Placeholder<Node>>();
}

class Models {
 public:
  Models(Factory& factory, const Document& document) : factory_(factory), document_(document) {}

  std::vector<Diagnostic> Add() && {
    for (const Element& model : document_.models) AddNode(model);
    return std::move(found_);
  }

 private:
  static constexpr std::array<NodeKind, 4> kKinds = {NodeKind::kAction, NodeKind::kCondition,
                                                     NodeKind::kDecorator, NodeKind::kControl};

  void Report(Place place, std::string message) {
    found_.push_back(document_.At(place, Severity::kError, std::move(message)));
  }
  static std::string Guess(std::string_view word, const std::vector<std::string>& known) {
    return DidYouMean(word, known, "<>");
  }

  void AddNode(const Element& model) {
    if (model.name == "SubTree") return;  // its ports are checked where a tree uses it
    const auto kind =
        std::ranges::find_if(kKinds, [&](NodeKind each) { return Name(each) == model.name; });
    if (kind == kKinds.end()) {
      return Report(model.at, "<" + model.name + "> has no place in <TreeNodesModel>" +
                                  Guess(model.name, {"Action", "Condition", "Decorator", "Control",
                                                     "SubTree"}));
    }
    const Attribute* id = model.Find("ID");
    if (id == nullptr) {
      return Report(model.at, "<" + model.name + "> needs the attribute 'ID', the node's name");
    }
    std::vector<ModelPort> ports;
    for (const Element& child : model.children) AddPort(child, ports);
    if (factory_.Find(id->value) != nullptr) return;
    const Result<> added = factory_.Register(id->value, {.kind = *kind,
                                                         .takes_time = false,
                                                         .make =
                                                             [kind = *kind, ports](Setup& setup) {
                                                               MakePorts(setup, ports);
                                                               return MakePlaceholder(kind);
                                                             },
                                                         .placeholder = true});
    if (!added) Report(id->value_at, added.error().message);
  }

  void AddPort(const Element& element, std::vector<ModelPort>& ports) {
    if (element.name == "MetadataFields" || element.name == "description") return;
    Direction direction = Direction::kIn;
    if (element.name == "output_port") {
      direction = Direction::kOut;
    } else if (element.name == "inout_port" || element.name == "bidirectional_port") {
      direction = Direction::kInOut;
    } else if (element.name != "input_port") {
      return Report(element.at,
                    "<" + element.name + "> has no place in a model" +
                        Guess(element.name, {"input_port", "output_port", "inout_port"}));
    }
    const Attribute* name = element.Find("name");
    if (name == nullptr) {
      return Report(element.at, "<" + element.name + "> needs the attribute 'name'");
    }
    const Attribute* type = element.Find("type");
    const bool has_default = element.Find("default") != nullptr;
    ports.push_back({{name->value, direction, type == nullptr ? nullptr : TypeNamed(type->value),
                      false, "", has_default ? element.Find("default")->value : ""},
                     has_default});
  }

  Factory& factory_;
  const Document& document_;
  std::vector<Diagnostic> found_;
};

}  // namespace

std::string TypeNameOf(const PortModel& port) {
  if (port.direction == Direction::kText) return "std::string";
  for (const TypeName& each : TypeNames()) {
    if (each.type == port.type) return std::string(each.name);
  }
  return "";
}

const Type* TypeNamed(std::string_view name) {
  for (const TypeName& each : TypeNames()) {
    if (each.name == name) return each.type;
  }
  return nullptr;
}

std::vector<Diagnostic> AddPlaceholders(Factory& factory, const Document& models) {
  return Models(factory, models).Add();
}

}  // namespace musher::tree
