#include "musher/modules/device/can_protocol.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <sstream>

#include "musher/base/check.hpp"

namespace musher::device {
namespace {

constexpr unsigned kBitsOfByte = 8;

Error Invalid(const CanId& id, const std::string& what) {
  return {static_cast<std::int32_t>(KeyCode::kParametersInvalid),
          "frame " + ToText(id) + " " + what};
}

std::string Short(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

// The bytes of the field, the highest one first.
std::uint64_t RawNumber(const CanField& field, const CanFrame& frame) {
  std::uint64_t raw = 0;
  for (std::size_t i = field.first; i <= field.last; ++i) {
    const std::size_t at = field.little_endian ? field.last - (i - field.first) : i;
    raw = raw << kBitsOfByte | frame.data.at(at);
  }
  return raw;
}

double Unscaled(const CanField& field, const CanFrame& frame) {
  const std::uint64_t raw = RawNumber(field, frame);
  if (field.bits) {
    const unsigned width = field.bits->high - field.bits->low + 1;
    return static_cast<double>(raw >> field.bits->low & ((1U << width) - 1U));
  }
  const std::size_t bytes = field.last - field.first + 1;
  if (field.type == CanType::kFloat) {
    return bytes == sizeof(float) ? std::bit_cast<float>(static_cast<std::uint32_t>(raw))
                                  : std::bit_cast<double>(raw);
  }
  if (field.type == CanType::kUnsigned) return static_cast<double>(raw);
  const auto unused = static_cast<unsigned>(kCanBytes - bytes) * kBitsOfByte;
  return static_cast<double>(static_cast<std::int64_t>(raw << unused) >> unused);
}

}  // namespace

std::string ToText(const CanId& id) {
  char text[16] = {};
  std::snprintf(text, sizeof text, id.extended ? "0x%08X" : "0x%03X", id.number);
  return text;
}

bool CanProtocol::HasField(std::string_view name) const {
  return std::ranges::count(fields, name, &CanField::name) > 0;
}

const CanCommand* CanProtocol::FindCommand(std::string_view name) const {
  const auto found = std::ranges::find(commands, name, &CanCommand::name);
  return found == commands.end() ? nullptr : &*found;
}

Result<double> Decode(const CanField& field, const CanFrame& frame) {
  if (frame.remote) return Invalid(frame.id, "asks for data and has none");
  if (frame.size <= field.last) {
    return Invalid(frame.id, "has " + std::to_string(frame.size) + " bytes, and '" + field.name +
                                 "' is in byte " + std::to_string(field.last));
  }
  const double value = Unscaled(field, frame) * field.zoom + field.offset;
  if (!std::isfinite(value))
    return Invalid(frame.id, "has a '" + field.name + "' that is no number");
  if ((field.least && value < *field.least) || (field.most && value > *field.most)) {
    const std::string least = field.least ? "from " + Short(*field.least) : "";
    const std::string most = field.most ? "up to " + Short(*field.most) : "";
    return Invalid(frame.id, "has " + Short(value) + " for '" + field.name + "', which is " +
                                 least + (field.least && field.most ? " " : "") + most);
  }
  return value;
}

CanFrame Encode(const CanCommand& command, std::span<const std::uint8_t> data) {
  MUSHER_CHECK(command.control.size() + data.size() <= kCanBytes);
  CanFrame frame;
  frame.id = command.id;
  frame.size = kCanBytes;
  const auto end = std::ranges::copy(command.control, frame.data.begin()).out;
  std::ranges::copy(data, end);
  return frame;
}

CanRecord::CanRecord(const std::vector<CanField>& fields) : fields_(fields) {
  for (const CanField& field : fields_) ids_.insert(field.id);
}

Result<bool> CanRecord::Take(const CanFrame& frame) {
  MUSHER_CHECK(Knows(frame.id));
  Values found;
  for (const CanField& field : fields_) {
    if (field.id != frame.id) continue;
    const auto value = Decode(field, frame);
    if (!value) return value.error();
    found[field.name] = value.value();
  }
  for (const auto& [name, value] : found) values_[name] = value;
  received_.insert(frame.id);
  if (received_.size() < ids_.size()) return false;
  received_.clear();
  return true;
}

std::vector<CanId> CanRecord::Missing() const {
  std::vector<CanId> missing;
  std::set_difference(ids_.begin(), ids_.end(), received_.begin(), received_.end(),
                      std::back_inserter(missing));
  return missing;
}

}  // namespace musher::device
