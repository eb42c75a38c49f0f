#pragma once
// The journal's table. Another layout gets another version; a file of another version is moved
// aside when the controller starts.

namespace musher::journal_schema {

inline constexpr int kApplicationId = 0x4d757368;  // "Mush", in the file's header
inline constexpr int kVersion = 1;

inline constexpr char kCreate[] = R"(
  CREATE TABLE entry (
    id            INTEGER PRIMARY KEY,  -- in the order of Append()
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

inline constexpr char kInsert[] = R"(
  INSERT INTO entry (wall_ns, steady_ns, epoch, switch_number, kind, actuator, code, message, data)
  VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?))";

// Newest first.
inline constexpr char kSelect[] = R"(
  SELECT wall_ns, steady_ns, epoch, switch_number, kind, actuator, code, message, data
  FROM entry WHERE wall_ns >= ? ORDER BY id DESC LIMIT ?)";

}  // namespace musher::journal_schema
