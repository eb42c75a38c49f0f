#pragma once
// The persisted fields of one part (a state, shared data, a skill) as values by names, and how they
// are taken from it and given back. See archive.hpp.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "musher/behavior/fsm/archive.hpp"

namespace musher::fsm {

using SavedValue = std::variant<bool, std::int64_t, double, std::string>;

struct SavedField {
  std::string name;
  SavedValue value;
  friend bool operator==(const SavedField&, const SavedField&) = default;
};

struct SavedPart {
  std::string name;
  std::vector<SavedField> fields;
  friend bool operator==(const SavedPart&, const SavedPart&) = default;
};

// Why something saved cannot be restored.
struct SnapshotFault {
  std::string key;  // the invalid key: "state", "states.TRACKING.lost_for", "inside.SHOW.commands"
  std::string what;

  friend bool operator==(const SnapshotFault&, const SnapshotFault&) = default;
};

// "true", "3", "0.5" or the text itself; and back, for a field of the same kind as `kind`.
std::string TextOf(const SavedValue& value);
std::optional<SavedValue> ValueOf(std::string_view text, const SavedValue& kind);

// "states" and "TRACKING" make "states.TRACKING".
std::string SnapshotKey(const std::string& prefix, const std::string& name);

// "there is no state TRAKCING; did you mean 'TRACKING'?"
std::string UnknownName(const std::string& kind, const std::string& name,
                        const std::vector<std::string>& known);

// Throws what `persist` throws, and for a field that occurs twice.
std::vector<SavedField> SaveFields(const std::function<void(Archive&)>& persist);

// Sets the fields that `persist` names. Adds a fault below `key` for a value of another kind, and
// for one of `fields` that `persist` does not name. Returns whether `persist` names any field.
bool RestoreFields(const std::vector<SavedField>& fields, const std::string& key,
                   const std::function<void(Archive&)>& persist,
                   std::vector<SnapshotFault>& faults);

}  // namespace musher::fsm
