#include "musher/modules/device/can_protocol_toml.hpp"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/rows.hpp"

namespace musher::device {
namespace {

namespace row = config_toml::row;
using config_toml::Findings;
using config_toml::Row;
using config_toml::Table;
using config_toml::TableReader;
using config_toml::Word;

constexpr std::uint32_t kHighestId = 0x7FF;
constexpr std::uint32_t kHighestExtendedId = 0x1FFFFFFF;
constexpr std::int64_t kLastByte = kCanBytes - 1;
constexpr double kLargest = std::numeric_limits<float>::max();

// "0x0083'41 00": apostrophes and spaces only separate.
std::optional<std::uint32_t> Hexadecimal(std::string text) {
  std::erase_if(text, [](char c) { return c == '\'' || c == ' '; });
  if (!text.starts_with("0x") && !text.starts_with("0X")) return std::nullopt;
  std::uint32_t value = 0;
  const char* const end = text.data() + text.size();
  const auto [rest, fault] = std::from_chars(text.data() + 2, end, value, 16);
  if (fault != std::errc() || rest != end) return std::nullopt;
  return value;
}

// The types of CyberDog's files, and their size in bytes.
struct NamedType {
  CanType type;
  std::size_t bytes;
};
std::vector<std::pair<std::string_view, NamedType>> Types() {
  constexpr std::size_t kByte = 1;
  return {
      {"bool", {CanType::kUnsigned, kByte}}, {"u8", {CanType::kUnsigned, kByte}},
      {"u16", {CanType::kUnsigned, 2}},      {"u32", {CanType::kUnsigned, 4}},
      {"u64", {CanType::kUnsigned, 8}},      {"i8", {CanType::kSigned, kByte}},
      {"i16", {CanType::kSigned, 2}},        {"i32", {CanType::kSigned, 4}},
      {"i64", {CanType::kSigned, 8}},        {"float", {CanType::kFloat, 4}},
      {"double", {CanType::kFloat, 8}},
  };
}

class Reader {
 public:
  Reader(const CanNames& names, Findings& findings) : names_(names), findings_(findings) {}

  CanProtocol Read(const Table& table) {
    TableReader root(table, {1, 1}, "", findings_);
    bool is_can = true;
    bool can_fd = false;
    std::string ignored;
    ReadRows(root, {row::Choice("protocol", is_can, {{"can", true}}), row::Text("name", ignored),
                    row::Required("can_interface", "the network interface of the bus, \"can0\"",
                                  row::Text("can_interface", protocol_.network_interface)),
                    row::Bool("extended_frame", extended_), row::Bool("canfd_enable", can_fd),
                    row::Check(
                        "canfd_enable", [&] { return !can_fd; },
                        "expected false: frames of CAN FD are not supported"),
                    NoEffect("timeout_us", "the time without a frame is silence_ms of [battery]"),
                    [](TableReader& reader) { RefuseArrays(reader); },
                    [this](TableReader& reader) { ReadFields(reader); },
                    [this](TableReader& reader) { ReadCommands(reader); }});
    return std::move(protocol_);
  }

 private:
  static Row NoEffect(std::string_view key, std::string_view why) {
    return [key, why = std::string(why)](TableReader& reader) {
      if (reader.Has(key)) reader.Warn(reader.At(key), key, "has no effect: " + why);
    };
  }
  // In CyberDog's files the meaning of their bytes is in its programs.
  static void RefuseArrays(TableReader& reader) {
    if (!reader.Has("array")) return;
    reader.Fault(reader.At("array"), "array",
                 "expected a [[var]] for each value: the bytes of an array have no names");
  }

  Row Id(CanId& id) {
    const auto read = [this, &id](TableReader& reader) {
      const auto word = reader.String("can_id");
      if (!word) return;
      const auto number = Hexadecimal(word->text);
      const std::uint32_t highest = extended_ ? kHighestExtendedId : kHighestId;
      if (!number || *number > highest) {
        const char* expected = extended_ ? "0x00000000 to 0x1FFFFFFF (extended_frame is true)"
                                         : "0x000 to 0x7FF (extended_frame is false)";
        reader.Fault(word->at, "can_id",
                     std::string("expected a hexadecimal number from ") + expected + ", found " +
                         config_toml::Quote(word->text));
      }
      id = {number.value_or(0), extended_};
    };
    return row::Required("can_id", "the id of the frame, such as \"0x00834100\"", read);
  }

  // One of `known`, and no second time in `taken`.
  Row Name(std::string_view key, std::string& name, const std::vector<std::string_view>& known,
           std::vector<std::string>& taken) {
    const auto read = [&, key](TableReader& reader) {
      const auto word = reader.String(key);
      if (!word) return;
      name = word->text;
      if (std::ranges::find(known, name) == known.end()) {
        reader.Fault(word->at, key,
                     "expected one of " + config_toml::Listing(known) + ", found " +
                         config_toml::Quote(name) + findings_.Guess(name, known));
      } else if (std::ranges::find(taken, name) != taken.end()) {
        reader.Fault(word->at, key, config_toml::Quote(name) + " is defined above already");
      }
      taken.push_back(name);
    };
    return row::Required(key, "the name of what the frame has", read);
  }

  static Row Limit(std::string_view key, std::optional<double>& limit) {
    return [&limit, key](TableReader& reader) {
      if (const auto found = reader.Number(key, -kLargest, kLargest)) limit = found;
    };
  }

  // [first, last] are bytes, [byte, high, low] bits of one.
  static void ReadPlace(TableReader& reader, CanField& field, const NamedType& type) {
    const auto place = reader.Integers("parser_param", 0, kLastByte);
    if (!place || reader.IsFaulty("parser_param")) return;
    const auto fault = [&](const std::string& message) {
      reader.Fault(reader.At("parser_param"), "parser_param", message);
    };
    if (place->size() != 2 && place->size() != 3) {
      return fault("expected [first byte, last byte] or [byte, high bit, low bit]");
    }
    field.first = static_cast<std::size_t>(place->at(0));
    if (place->size() == 3) {
      field.last = field.first;
      field.bits = {static_cast<unsigned>(place->at(1)), static_cast<unsigned>(place->at(2))};
      if (field.bits->high < field.bits->low) fault("expected the high bit before the low bit");
      if (type.type != CanType::kUnsigned || type.bytes > 1) fault("bits are of type u8 or bool");
      field.type = CanType::kUnsigned;
      return;
    }
    field.last = static_cast<std::size_t>(place->at(1));
    if (field.last < field.first) return fault("expected the first byte before the last byte");
    const std::size_t bytes = field.last - field.first + 1;
    field.type = type.type;
    if (bytes == type.bytes) return;
    // CyberDog's rule for "float" and "double" in fewer bytes: an integer, which var_zoom scales.
    const bool scaled =
        type.type == CanType::kFloat && bytes < type.bytes && (bytes == 2 || bytes == 4);
    if (scaled) {
      field.type = CanType::kSigned;
    } else {
      fault("expected " + std::to_string(type.bytes) + " bytes for this var_type, found " +
            std::to_string(bytes));
    }
  }

  void ReadFields(TableReader& root) {
    std::vector<std::string> taken;
    for (TableReader& reader : root.Subs("var")) {
      CanField field;
      NamedType type{CanType::kUnsigned, 1};
      std::string ignored;
      bool is_auto = true;
      ReadRows(
          reader,
          {Id(field.id), Name("var_name", field.name, names_.fields, taken),
           row::Required("var_type", "\"u8\", \"i16\", \"float\" …",
                         row::Choice("var_type", type, Types())),
           row::Required("parser_param", "[first byte, last byte] or [byte, high bit, low bit]",
                         [&](TableReader& table) { ReadPlace(table, field, type); }),
           row::Choice("byte_order", field.little_endian, {{"big", false}, {"little", true}}),
           row::Choice("parser_type", is_auto, {{"auto", true}, {"var", true}, {"bit", true}}),
           row::Number("var_zoom", field.zoom, -kLargest, kLargest),
           row::Number("offset", field.offset, -kLargest, kLargest), Limit("least", field.least),
           Limit("most", field.most),
           row::Check(
               "most", [&] { return !field.least || !field.most || *field.least <= *field.most; },
               "expected least or more"),
           row::Text("description", ignored)});
      protocol_.fields.push_back(std::move(field));
    }
    Need(root, "var", names_.needed_field, taken);
  }

  void ReadCommands(TableReader& root) {
    std::vector<std::string> taken;
    for (TableReader& reader : root.Subs("cmd")) {
      CanCommand command;
      std::string ignored;
      ReadRows(reader, {Id(command.id), Name("cmd_name", command.name, names_.commands, taken),
                        [&](TableReader& table) { ReadControl(table, command); },
                        row::Text("description", ignored)});
      protocol_.commands.push_back(std::move(command));
    }
    Need(root, "cmd", names_.needed_command, taken);
  }

  // ctrl_len bytes, of which ctrl_data has the first ones.
  void ReadControl(TableReader& reader, CanCommand& command) const {
    const auto most = static_cast<std::int64_t>(kCanBytes - names_.data_bytes);
    const auto size = static_cast<std::size_t>(reader.Integer("ctrl_len", 0, most).value_or(0));
    const auto words = reader.Strings("ctrl_data", {.may_be_empty = true, .may_repeat = true})
                           .value_or(std::vector<Word>());
    if (words.size() > size) {
      reader.Fault(reader.At("ctrl_data"), "ctrl_data", "expected at most ctrl_len bytes");
    }
    for (const Word& word : words) {
      const auto byte = Hexadecimal(word.text);
      if (!byte || *byte > std::numeric_limits<std::uint8_t>::max()) {
        reader.Fault(word.at, "ctrl_data", "expected a byte such as \"0x1F\"");
      }
      command.control.push_back(static_cast<std::uint8_t>(byte.value_or(0)));
    }
    command.control.resize(size);
  }

  static void Need(TableReader& root, std::string_view key, std::string_view needed,
                   const std::vector<std::string>& found) {
    if (needed.empty() || std::ranges::find(found, needed) != found.end()) return;
    root.Fault(root.At(key), key, "there is no " + config_toml::Quote(needed));
  }

  const CanNames& names_;
  Findings& findings_;
  bool extended_ = false;
  CanProtocol protocol_;
};

}  // namespace

Parsed<CanProtocol> ReadCanText(std::string_view text, const std::string& path,
                                const CanNames& names) {
  return config_toml::ReadTextWith<Parsed<CanProtocol>>(
      text, path,
      [&](const Table& root, Findings& findings) { return Reader(names, findings).Read(root); });
}

Parsed<CanProtocol> ReadCanFile(const std::string& path, const CanNames& names) {
  return config_toml::ReadFileWith(path, [&](std::string_view text, const std::string& file) {
    return ReadCanText(text, file, names);
  });
}

}  // namespace musher::device
