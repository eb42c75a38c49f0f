#pragma once
// The journal's tables. Another layout gets another version. When the controller starts, it moves a
// file of a newer version aside and upgrades an older one.
//
// Both tables share one sequence of ids, in the order of Append(): an id in neither table is a lost
// row.

namespace musher::journal_schema {

inline constexpr int kApplicationId = 0x4d757368;  // "Mush", in the file's header
inline constexpr int kVersion = 3;

// Version 1 had only `entry`, up to `data`.
inline constexpr char kCreateVersion1[] = R"(
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
    data          TEXT NOT NULL
  ))";

inline constexpr char kUpgradeTo2[] = R"(
  ALTER TABLE entry ADD COLUMN record INTEGER NOT NULL DEFAULT 0;  -- id of the decision's record
  ALTER TABLE entry ADD COLUMN cause INTEGER NOT NULL DEFAULT 0;   -- `record` it follows from
  ALTER TABLE entry ADD COLUMN state TEXT NOT NULL DEFAULT '';     -- the machine's new state
  ALTER TABLE entry ADD COLUMN checksum INTEGER;  -- none: written by version 1
  CREATE TABLE input (
    id       INTEGER PRIMARY KEY,
    wall_ns  INTEGER NOT NULL,
    kind     TEXT NOT NULL,    -- "config", "event", "machine" (a snapshot)
    data     TEXT NOT NULL,    -- JSON
    checksum INTEGER NOT NULL
  ))";

// The checksum of an entry with an event includes it.
inline constexpr char kUpgradeTo3[] = "ALTER TABLE entry ADD COLUMN event TEXT NOT NULL DEFAULT ''";

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

inline constexpr char kEntryColumnsVersion1[] =
    "id, wall_ns, steady_ns, epoch, switch_number, kind, actuator, code, message, data";
inline constexpr char kEntryColumnsVersion2[] =
    "id, wall_ns, steady_ns, epoch, switch_number, kind, actuator, code, message, data, record, "
    "cause, state, checksum";
inline constexpr char kEntryColumns[] =
    "id, wall_ns, steady_ns, epoch, switch_number, kind, actuator, code, message, data, record, "
    "cause, state, checksum, event";
inline constexpr char kInputColumns[] = "id, wall_ns, kind, data, checksum";

}  // namespace musher::journal_schema
