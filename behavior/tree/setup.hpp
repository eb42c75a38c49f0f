#pragma once
// What the constructor of a node gets: it makes the ports of the node from the attributes of its
// XML element.
//
//   explicit Move(tree::Setup& setup)
//       : row_(setup.Input<int>("row", "of the grid")),
//         timeout_s_(setup.Input<double>("timeout_sec", 30.0)),
//         message_(setup.Output<std::string>("message")) {}
//
// What is missing or wrong there is reported at the place in the XML, for all nodes at once.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/behavior/tree/board.hpp"
#include "musher/behavior/tree/document.hpp"
#include "musher/behavior/tree/port.hpp"
#include "musher/behavior/tree/script.hpp"
#include "musher/behavior/tree/wake_up.hpp"

namespace musher::tree {

enum class Direction : std::uint8_t { kIn, kOut, kInOut, kText };

struct PortModel {
  std::string name;
  Direction direction = Direction::kIn;
  const Type* type = nullptr;  // null: any
  bool required = false;
  std::string doc;          // for people
  std::string otherwise{};  // the default as a text, or an entry, as "{key}"; empty: there is none
};

// The default of a port: an entry. "=" is the entry with the name of the port.
struct FromEntry {
  std::string key;
};

class Builder;

class Setup {
 public:
  // Set-up of a tree's node; without `builder`, only to learn the ports.
  Setup(Builder* builder, const Element& element, Board& board, const Enums& enums);
  Setup(const Setup&) = delete;
  Setup& operator=(const Setup&) = delete;

  // A port that has to be set.
  template <class T>
  InPort<T> Input(std::string_view name, std::string_view doc = "") {
    return MakeInput<T>({std::string(name), Direction::kIn, TypeOf<T>(), true, std::string(doc)},
                        std::nullopt);
  }
  // A port with a default value.
  template <class T>
  requires(!std::convertible_to<T, std::string_view>) InPort<T> Input(std::string_view name,
                                                                      T otherwise,
                                                                      std::string_view doc = "") {
    const std::string shown = Shown(otherwise);
    return MakeInput<T>(
        {std::string(name), Direction::kIn, TypeOf<T>(), false, std::string(doc), shown},
        std::move(otherwise));
  }
  // A port that reads this entry where the XML leaves it out.
  template <class T>
  InPort<T> Input(std::string_view name, const FromEntry& entry, std::string_view doc = "") {
    return MakeInput<T>(Defaulting<T>(name, Direction::kIn, entry, doc), std::nullopt);
  }
  // A port that may be missing: its Find() is null then.
  template <class T>
  InPort<T> OptionalInput(std::string_view name, std::string_view doc = "") {
    return MakeInput<T>({std::string(name), Direction::kIn, TypeOf<T>(), false, std::string(doc)},
                        std::nullopt);
  }
  template <class T>
  OutPort<T> Output(std::string_view name, std::string_view doc = "") {
    return {
        std::string(name),
        Connect({std::string(name), Direction::kOut, TypeOf<T>(), false, std::string(doc)}).entry};
  }
  template <class T>
  OutPort<T> Output(std::string_view name, const FromEntry& entry, std::string_view doc = "") {
    return {std::string(name), Connect(Defaulting<T>(name, Direction::kOut, entry, doc)).entry};
  }
  template <class T>
  InOutPort<T> InOut(std::string_view name, std::string_view doc = "") {
    return MakeInOut<T>(
        {std::string(name), Direction::kInOut, TypeOf<T>(), true, std::string(doc)});
  }
  template <class T>
  InOutPort<T> InOut(std::string_view name, const FromEntry& entry, std::string_view doc = "") {
    return MakeInOut<T>(Defaulting<T>(name, Direction::kInOut, entry, doc));
  }

  // An entry of any type: "key" or "{key}". Null: the port is missing, which is an error.
  Entry* Key(std::string_view name, std::string_view doc = "");
  // A text that is fixed in the XML. Empty: it is missing.
  std::string Text(std::string_view name, bool required, std::string_view doc = "");
  std::optional<Script> ScriptOf(std::string_view name, bool is_condition);
  // An attribute without a port of its own: a fixed text or an entry.
  struct Connection {
    Entry* entry = nullptr;
    const Attribute* text = nullptr;
  };
  Connection Connect(PortModel model);

  const std::string& name() const { return name_; }  // of the node
  Board& board() { return board_; }
  // For a node that awaits something outside the tree: asks for a tick as soon as it has come.
  WakeUp wake_up() const;
  const Enums& enums() const { return enums_; }
  // An error or a warning at an attribute, or at the node where that is missing.
  void Report(std::string_view attribute, Severity severity, std::string what);
  // An input of a model that the element leaves out and that has no default.
  void NoteUnset(const std::string& port);

  const std::vector<PortModel>& ports() const { return ports_; }

 private:
  template <class T>
  static std::string Shown(const T& value) {
    if constexpr (!HasText<T> && !Numeric<T>) return "";
    Value shown;
    shown.Set(value);
    return shown.Shown();
  }
  template <class T>
  InPort<T> MakeInput(PortModel model, std::optional<T> otherwise) {
    const std::string name = model.name;
    const Connection connection = Connect(std::move(model));
    if (connection.text != nullptr) otherwise = FixedAs<T>(*connection.text);
    return {name, connection.entry, std::move(otherwise)};
  }
  template <class T>
  InOutPort<T> MakeInOut(PortModel model) {
    const std::string name = model.name;
    const Connection connection = Connect(std::move(model));
    std::optional<T> fixed;
    if (connection.text != nullptr) fixed = FixedAs<T>(*connection.text);
    return {name, connection.entry, std::move(fixed)};
  }
  template <class T>
  static PortModel Defaulting(std::string_view name, Direction direction, const FromEntry& entry,
                              std::string_view doc) {
    return {std::string(name),    direction, TypeOf<T>(), false, std::string(doc),
            "{" + entry.key + "}"};
  }
  template <class T>
  std::optional<T> FixedAs(const Attribute& attribute) {
    if constexpr (Numeric<T> && !std::same_as<T, Status>) {
      const auto known = enums_.find(attribute.value);
      if (known != enums_.end() && Fits<T>(known->second)) return static_cast<T>(known->second);
    }
    if constexpr (HasJson<T>) {
      if (const auto json = JsonIn(attribute.value)) {
        Result<T> value = Convert<T>::FromJson(*json);
        if (value) return std::move(value).value();
        Report(attribute.name, Severity::kError,
               "port '" + attribute.name + "': " + value.error().message);
        return std::nullopt;
      }
    }
    if constexpr (HasText<T>) {
      Result<T> value = Convert<T>::FromText(attribute.value);
      if (value) return std::move(value).value();
      constexpr bool kMayBeEnum = Numeric<T> && !std::same_as<T, Status> && !std::same_as<T, bool>;
      const std::string names = kMayBeEnum && IsName(attribute.value) ? EnumNames() : "";
      Report(attribute.name, Severity::kError,
             "port '" + attribute.name + "': " + value.error().message +
                 (names.empty() ? "" : ", or " + names));
    } else if (std::is_enum_v<T> && !enums_.empty()) {
      Report(attribute.name, Severity::kError,
             "port '" + attribute.name + "': " + NoValue(attribute.value, EnumNames()).message);
    } else {
      Report(attribute.name, Severity::kError,
             "port '" + attribute.name + "' has a type that no text can be converted to (" +
                 std::string(TypeOf<T>()->name) + "): expected an entry, such as \"{" +
                 attribute.name + "}\"" + (HasJson<T> ? ", or JSON, such as json:{...}" : ""));
    }
    return std::nullopt;
  }

  static bool IsName(std::string_view text);  // begins with a letter
  std::string EnumNames() const;              // "BLUE (2), RED (1)"

  Builder* builder_;
  const Element& element_;
  Board& board_;
  const Enums& enums_;
  std::string name_;
  std::vector<PortModel> ports_;
};

// The key of "{key}", or of "{=}" for the port `name`. Nothing: it is a fixed text.
std::optional<std::string_view> KeyOf(std::string_view value, std::string_view name);

}  // namespace musher::tree
