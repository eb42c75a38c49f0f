#pragma once
// The journal's tables. Another layout, or another name of a recorded field, gets another version:
// a controller moves a file of one aside when it starts.
//
// Both tables share one sequence of ids, in the order of Append(): an id in neither table is a lost
// row.

#include <cstdint>
#include <string>

namespace musher::journal_schema {

inline constexpr int kApplicationId = 0x4d757368;  // "Mush", in the file's header
inline constexpr int kVersion = 4;                 // 1 to 3: Musher 0.1

inline std::string OtherVersion(std::int64_t version) {
  return "its version is " + std::to_string(version) + ", not " + std::to_string(kVersion) +
         (version < kVersion ? ": an earlier Musher wrote it" : ": a newer Musher wrote it");
}

inline constexpr char kCreate[] = R"(
  CREATE TABLE entry (
    id            INTEGER PRIMARY KEY,
    wall_ns       INTEGER NOT NULL,
    steady_ns     INTEGER NOT NULL,
    epoch         INTEGER NOT NULL,
    switch_number INTEGER NOT NULL,
    kind          TEXT NOT NULL,
    actuator      TEXT NOT NULL,
    code          INTEGER NOT NULL,
    message       TEXT NOT NULL,
    data          TEXT NOT NULL,
    record        INTEGER NOT NULL,  -- id of the decision's record
    cause         INTEGER NOT NULL,  -- `record` it follows from
    state         TEXT NOT NULL,     -- the machine's new state
    event         TEXT NOT NULL,
    checksum      INTEGER NOT NULL
  );
  CREATE TABLE input (
    id       INTEGER PRIMARY KEY,
    wall_ns  INTEGER NOT NULL,
    kind     TEXT NOT NULL,    -- "config", "event", "machine" (a snapshot)
    data     TEXT NOT NULL,    -- JSON
    checksum INTEGER NOT NULL
  ))";

inline constexpr char kInsertEntry[] = R"(
  INSERT INTO entry (id, wall_ns, steady_ns, epoch, switch_number, kind, actuator, code, message,
                     data, record, cause, state, checksum, event)
  VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?))";
inline constexpr char kInsertInput[] =
    "INSERT INTO input (id, wall_ns, kind, data, checksum) VALUES (?, ?, ?, ?, ?)";

// The first row at or after an id from which a replay can start.
inline constexpr char kNextStart[] =
    "SELECT COALESCE(MIN(id), 0) FROM input WHERE id >= ? AND kind IN ('config', 'machine')";

// Keeps the newest config up to the id: the next snapshot needs it.
inline constexpr char kTrimInput[] =
    "DELETE FROM input WHERE id < ?1 AND id <> "
    "(SELECT COALESCE(MAX(id), 0) FROM input WHERE kind = 'config' AND id <= ?1)";
inline constexpr char kTrimEntry[] = "DELETE FROM entry WHERE id < ?";

// The oldest id that trimming can remove, and the newest.
inline constexpr char kOldest[] =
    "SELECT COALESCE(MIN(id), 0) FROM (SELECT MIN(id) AS id FROM entry UNION ALL "
    "SELECT MIN(id) FROM input WHERE kind <> 'config')";
inline constexpr char kNewest[] =
    "SELECT COALESCE(MAX(id), 0) FROM (SELECT MAX(id) AS id FROM entry UNION ALL "
    "SELECT MAX(id) FROM input)";

inline constexpr char kEntryColumns[] =
    "id, wall_ns, steady_ns, epoch, switch_number, kind, actuator, code, message, data, record, "
    "cause, state, checksum, event";
inline constexpr char kInputColumns[] = "id, wall_ns, kind, data, checksum";

}  // namespace musher::journal_schema
