#pragma once
// What the frames of one device on a CAN bus mean, as data: values in the bytes of received frames,
// and commands. Plain values, no IO; can_protocol_toml.hpp reads it from a file.

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "musher/modules/device/can_frame.hpp"

namespace musher::device {

enum class CanType : std::uint8_t {
  kUnsigned,  // also a truth value
  kSigned,
  kFloat,  // IEEE 754, of 4 or 8 bytes
};

// A value in a frame: the number in bytes `first` to `last`, or in the bits `high_bit` to `low_bit`
// of byte `first`; times `zoom`, plus `offset`.
struct CanField {
  std::string name;
  CanId id;
  CanType type = CanType::kUnsigned;
  std::size_t first = 0;
  std::size_t last = 0;
  bool little_endian = false;  // the last byte is the highest one
  struct Bits {
    unsigned high = 0;
    unsigned low = 0;

    friend bool operator==(const Bits&, const Bits&) = default;
  };
  std::optional<Bits> bits;
  double zoom = 1;
  double offset = 0;
  std::optional<double> least;  // a value beyond them is refused
  std::optional<double> most;

  friend bool operator==(const CanField&, const CanField&) = default;
};

// A frame of 8 bytes: `control`, then the data of the call, then zeros.
struct CanCommand {
  std::string name;
  CanId id;
  std::vector<std::uint8_t> control;

  friend bool operator==(const CanCommand&, const CanCommand&) = default;
};

struct CanProtocol {
  std::string network_interface = "can0";
  std::vector<CanField> fields;
  std::vector<CanCommand> commands;

  bool HasField(std::string_view name) const;
  const CanCommand* FindCommand(std::string_view name) const;  // null: none

  friend bool operator==(const CanProtocol&, const CanProtocol&) = default;
};

// Fails with ParametersInvalid when the frame is too short, asks for data, or the value is not
// finite or out of its range.
Result<double> Decode(const CanField& field, const CanFrame& frame);

// `data` has at most 8 bytes with the control bytes, which is the caller's to know.
CanFrame Encode(const CanCommand& command, std::span<const std::uint8_t> data);

// Collects the values of all frames of a device: a record is complete once each of its ids has been
// received since the last record. A refused frame counts as not received.
class CanRecord {
 public:
  using Values = std::map<std::string, double, std::less<>>;

  explicit CanRecord(const std::vector<CanField>& fields);

  bool Knows(const CanId& id) const { return ids_.count(id) > 0; }
  const std::set<CanId>& ids() const { return ids_; }

  // Whether the record is complete with this frame, of an id that it knows.
  Result<bool> Take(const CanFrame& frame);
  // Of the last complete record; until the next Take().
  const Values& values() const { return values_; }
  // The ids that the next record lacks.
  std::vector<CanId> Missing() const;
  // The frames so far belong to no record: the bus was lost.
  void Forget() { received_.clear(); }

 private:
  const std::vector<CanField> fields_;
  std::set<CanId> ids_;
  std::set<CanId> received_;
  Values values_;
};

}  // namespace musher::device
