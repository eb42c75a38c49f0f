#pragma once
// A table of a config as rows: each has a key, the variable that gets its value, and the values
// that are permitted. The variable keeps its value, the default, where the key is missing or its
// value is wrong, which is reported with its line as by TableReader. Keys without a row are errors.
//
//   ReadRows(root, {row::Time("self_check_ms", config.self_check_time),
//                   row::Sub("lane", {row::Number("width_m", lane.width_m, 0.2, 5),
//                                     row::Degrees("jump_deg", lane.jump_rad, 1, 180)})});
//
// Rows are read in their order. What one key permits may depend on another one: row::Check().

#include <concepts>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/base/toml/table_reader.hpp"

namespace musher::config_toml {

// Reads one key, or several: those below, or a function of a module. What it refers to must outlive
// the reading.
using Row = std::function<void(TableReader&)>;
using Rows = std::vector<Row>;

// Reads the rows, and reports keys of the table that none of them has read.
void ReadRows(TableReader& reader, const Rows& rows);

namespace row {

Row Number(std::string_view key, double& value, double least, double most);
// As many numbers as `values` has, such as [x, y]; `expected` is the message otherwise.
Row Numbers(std::string_view key, std::vector<double*> values, double least, double most,
            std::string_view expected);
// The file has degrees.
Row Degrees(std::string_view key, double& value_rad, double least_deg, double most_deg);
template <std::integral T>
Row Integer(std::string_view key, T& value, std::int64_t least, std::int64_t most,
            std::string_view unit = "") {
  return [=, &value](TableReader& reader) {
    if (const auto found = reader.Integer(key, least, most, unit)) value = static_cast<T>(*found);
  };
}
Row Time(std::string_view key, Duration& value, std::int64_t least_ms = 1);
Row Bool(std::string_view key, bool& value);
Row Text(std::string_view key, std::string& value);
// A path, which is relative to the folder of the config.
Row File(std::string_view key, std::string& value, std::filesystem::path folder);
// A program and its arguments. A program with a '/' is relative to `folder`, another one is looked
// up in PATH.
Row Program(std::string_view key, std::vector<std::string>& argv, std::filesystem::path folder,
            ListRule rule = {.may_repeat = true});
// `example` is a name that a topic of this key has, in messages.
Row Topic(std::string_view key, std::string& value, std::string_view example, TopicRule rule = {});
// One of a few words, each with its meaning.
template <typename T>
Row Choice(std::string_view key, T& value,
           std::vector<std::pair<std::string_view, std::type_identity_t<T>>> choices) {
  return
      [=, &value](TableReader& reader) { value = reader.Choice<T>(key, choices).value_or(value); };
}
// A table of its own, if there is one.
Row Sub(std::string_view key, Rows rows);
// The same, and an error if there is none.
Row Required(std::string_view key, std::string_view expected, Row row);
// Reports `message` at `key` where `holds` is false once the rows before it were read.
Row Check(std::string_view key, std::function<bool()> holds, std::string_view message);

}  // namespace row
}  // namespace musher::config_toml
